#include "cohesion_model_sjkr.h"
#include "cohesion_model_sjkr2.h"
