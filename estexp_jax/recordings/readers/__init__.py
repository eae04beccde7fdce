"""One module for each file format; `read.py` chooses among them."""
