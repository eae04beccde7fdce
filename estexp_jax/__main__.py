"""`python -m estexp_jax`: the command `estexp`."""

from estexp_jax.cli.main import program

if __name__ == "__main__":
    program()
