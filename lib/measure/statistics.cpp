// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <mapjoin/measure/statistics.hpp>

namespace mapjoin {

double chi_squared_upper_tail(double value, double dof) {
  if (dof <= 0.0) return 1.0;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(dof), std::max(0.0, value)));
}

double chi_squared_quantile(double p, double dof) {
  if (dof <= 0.0) return 0.0;
  return boost::math::quantile(boost::math::chi_squared(dof), p);
}

}  // namespace mapjoin
