"""What every node uses: names, clock, parameters, conversions."""
