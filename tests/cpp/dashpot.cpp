// Force of a dashpot beside the springs of a contact. Lines: force of the springs along two directions [N], share that
// sticks, coefficient [N s/m], Coulomb's limit [N], velocity along both [m/s].
#include "demlaws_shear.h"
#include <cstdio>

int main() {
  demlaws::ShearStep step = {};
  double coefficient, limit, velocity[2], viscous[2];
  while (scanf("%lf %lf %lf %lf %lf %lf %lf", step.force, step.force + 1, &step.stuck, &coefficient, &limit, velocity,
               velocity + 1) == 7) {
    step.damp(coefficient, limit, velocity, viscous);
    printf("%.17g %.17g\n", viscous[0], viscous[1]);
  }
}
