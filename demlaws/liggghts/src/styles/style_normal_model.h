// the plugin brings its own normal model
