"""The library of terms from which unknown laws are composed."""
