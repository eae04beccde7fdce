"""What `check` found, as tables, sentences and a figure."""
