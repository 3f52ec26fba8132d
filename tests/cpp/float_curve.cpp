// A curve of a table in single precision against double: what tests compare and docs/how-to/own-code.md prints. Words:
// table, "unloading" for its second curve. Prints largest relative errors of force and stiffness: of the look-up at one
// and the same overlap; of an overlap that was rounded; then those of an overlap that is a difference of positions
// between X and 2X, for each further pair of words X and force [N]; the size in kB last.
#include "demlaws_float.h"
#include "demlaws_table.h"

static double beside(const demlaws::Curve &curve, double u) { // relative distance of the nearest kink
  double nearest = 1.;
  for (double kink : curve.kinks()) nearest = std::min(nearest, fabs(u / kink - 1.));
  return nearest;
}

int main(int count, char **words) {
  const demlaws::Table table(words[1]);
  const bool second = count > 2 && !strcmp(words[2], "unloading");
  const demlaws::Curve &curve = second ? table.unloading_curve() : table.loading_curve();
  const demlaws::FloatCells cells(curve);
  float none, slope_of_none;
  if (demlaws::look_up(cells.view(), (float)(1.01 * curve.last()), none, slope_of_none)) return puts("beyond"), 1;
  if (!demlaws::look_up(cells.view(), NAN, none, slope_of_none) || none == none) return puts("NaN"), 1;
  double errors[4] = {0., 0., 0., 0.};
  const int points = 400000;
  for (int i = 0; i < points; i++) {
    const double low = 0.1 * curve.floor(), u = low * pow(curve.last() / low, (i + 0.5) / points);
    const float rounded = (float)u;
    double s, slope, exact_s, exact_slope;
    float single_s, single_slope;
    if (!demlaws::look_up(cells.view(), rounded, single_s, single_slope)) return puts("outside"), 1;
    curve.evaluate(u, exact_s, exact_slope);
    curve.evaluate(rounded, s, slope);
    if (beside(curve, u) < 2e-7) continue; // on which side of a kink it is is a matter of rounding
    const float root = sqrtf(single_s), force = root * single_s, stiffness = root * single_slope;
    const double exact = sqrt(exact_s), at_rounded = sqrt(s);
    errors[0] = std::max(errors[0], fabs(force / (at_rounded * s) - 1.));
    errors[1] = std::max(errors[1], fabs(stiffness / (at_rounded * slope) - 1.));
    errors[2] = std::max(errors[2], fabs(at_rounded * s / (exact * exact_s) - 1.));
    errors[3] = std::max(errors[3], fabs(at_rounded * slope / (exact * exact_slope) - 1.));
  }
  for (double error : errors) printf("%.3g ", error);
  const double radius = table.of_contact("radius", 0.), modulus = table.of_contact("modulus", 0.);
  const double length = demlaws::Pair(table, modulus).length_of(radius);
  for (int n = second ? 3 : 2; n + 1 < count; n += 2) {
    const double s = pow(0.75 * atof(words[n + 1]) / (modulus * sqrt(radius)), 2. / 3.) / length;
    const double overlap = curve.where(s) * length, place = atof(words[n]);
    double worst = 0.;
    for (int i = 0; i < 1000; i++) {
      const double x = place * (1. + 0.001 * i), other = x + 4. * radius - overlap; // two spheres of radius 2 R
      const float apart = (float)other - (float)x, found = (float)(4. * radius) - apart;
      float single_s, slope;
      demlaws::look_up(cells.view(), found / (float)length, single_s, slope);
      worst = std::max(worst, fabs(pow(std::max(single_s, 0.f) / s, 1.5) - 1.));
    }
    printf("%.3g ", worst);
  }
  printf("%.3g\n", 4e-3 * (double)(cells.cells().size() + cells.splits().size()));
}
