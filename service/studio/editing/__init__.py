"""The scene, edited by hand."""
