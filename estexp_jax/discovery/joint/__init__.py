"""The joint sparse fit: all plausible effects at all places fitted together over short windows, then pruned."""
