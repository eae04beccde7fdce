"""Finding the physics that a simulator lacks: locate, name, model, prove, abstain."""
