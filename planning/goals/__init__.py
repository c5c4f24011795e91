"""From a goal to goal configurations."""
