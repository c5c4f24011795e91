"""Wire types: what goes over HTTP, validated strictly, described for generated clients."""
