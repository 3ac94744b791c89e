"""The two-plate campaign: data of bursts and campaigns, models of the rig, and what is uncertain of both."""
