"""A damaged robot in the world, met through files: controllers go out, recordings of trials come in."""
