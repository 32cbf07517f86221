"""The plots of each experiment, drawn from the raw series and figures of the run."""
