"""The renderer: queues, passes, the loop over generations, tiles, the film, and the public API over them."""
