// none beside the laws
