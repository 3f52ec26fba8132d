// no cohesion model is supported
