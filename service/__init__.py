"""The Wayproof service: planning over HTTP, as durable jobs in killable processes."""
