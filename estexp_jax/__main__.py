"""`python -m estexp_jax`: the command `estexp`."""

import sys

from estexp_jax.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
