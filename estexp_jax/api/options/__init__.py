"""One frozen dataclass a command: its fields are the command's options, their docstrings its `--help`.

The Python doors read the same classes: they check keywords and numbers by them. The modules import nothing that
computes, so that `--help` and completion stay fast.
"""
