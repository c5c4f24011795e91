"""Commands, one file each; `service.cli.app` names them."""
