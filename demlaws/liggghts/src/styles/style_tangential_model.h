#include "tangential_model_history.h"
#include "tangential_model_no_history.h"
