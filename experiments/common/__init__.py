"""What the experiments of `recover` share: their runs, one folder each, and how they are counted and drawn."""
