// The headers of LIGGGHTS that the plugin needs, in an order in which they compile.
#ifndef DEMLAWS_STOCK_H
#define DEMLAWS_STOCK_H
// clang-format off
#include <mpi.h>
#include "lammps.h"
#include "pointers.h"
#include "memory.h"
#include "compute.h"
#include "error.h"
#include "atom.h"
#include "comm.h"
#include "force.h"
#include "group.h"
#include "update.h"
#include "modify.h"
#include "domain.h"
#include "neighbor.h"
#include "neigh_list.h"
#include "pair.h"
#include "fix_contact_history.h"
#include "fix_contact_property_atom.h"
#include "fix_property_atom.h"
#include "granular_pair_style.h"
#include "granular_wall.h"
// clang-format on
#endif
