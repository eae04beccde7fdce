"""The library from which laws that no catalogue holds are put together."""
