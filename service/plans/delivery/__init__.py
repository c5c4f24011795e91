"""What a plan delivered, to use and to look at: samples, files, charts, pages."""
