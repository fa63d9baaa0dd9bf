"""Every device users have, through our engine and through Radiance's: `make devices-report`."""
