"""Studies of many flights: the paper's figures, real flights, validation of the plants."""
