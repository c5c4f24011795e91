"""Problems for cars."""
