"""One module a file format; `read.py` chooses among them."""
