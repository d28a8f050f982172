// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Full SLAM over several regions per rank, one after the other: each thread of a rank holds the factor of one of them at a
// time, besides that of what its regions share.

#include <mapjoin/distributed/regions/region_elimination.hpp>
#include <mapjoin/distributed/regions/region_metric.hpp>
#include <mapjoin/distributed/regions/region_solver.hpp>

namespace mapjoin::distributed {

/// A LeastSquaresProblem that all ranks solve alike, as RegionProblem is. A rank's vectors are those of its regions one after
/// the other. Linearising also eliminates, for both need the region's matrix; a solve makes each region's factor once more for
/// back substitution.
template <int Dim>
class RegionsInTurn {
 public:
  RegionsInTurn(const Communicator& comm, const Regions<Dim>& regions, const MumpsOptions& options);
  RegionsInTurn(const RegionsInTurn&) = delete;
  RegionsInTurn& operator=(const RegionsInTurn&) = delete;

  double linearise();
  void add_curvature();
  const Eigen::VectorXd& gradient() const { return gradient_; }
  double slope(const Eigen::VectorXd& v) const { return comm_.sum(gradient_.dot(v)); }
  RegionMetric metric() const { return {comm_, shared_, diagonal_}; }
  double curvature(const Eigen::VectorXd& v);
  std::optional<Variable> factorise(double damping);
  const Eigen::VectorXd& solve();
  StepSize step_size(const Eigen::VectorXd& step) const;
  double try_step(const Eigen::VectorXd& step);
  void accept() { std::swap(estimates_, candidates_); }

  const Values<Dim>& estimate(std::size_t region) const { return estimates_[region]; }
  const Interface& interface() const { return interface_; }
  RegionSolver& solver() { return solver_; }
  /// Bytes of memory for the part of its factor that this rank holds at a time.
  std::int64_t factor_bytes() const { return solver_.bytes_in_memory() + largest_bytes_; }
  /// A sentence on what the last factorisation found free to move within a region of this rank; "" if nothing.
  std::string free_here(const LogPart<Dim>& whole);

 private:
  /// The results of a region's elimination that are kept.
  struct Eliminated {
    double chi2 = 0.0;
    Eigen::VectorXd forward;  ///< RegionElimination::forward() of the gradient.
    bool is_singular = false;
  };
  /// The entries of a region in a vector.
  auto part(Eigen::VectorXd& v, std::size_t region) const {
    return v.segment(firsts_[region], firsts_[region + 1] - firsts_[region]);
  }
  auto part(const Eigen::VectorXd& v, std::size_t region) const {
    return v.segment(firsts_[region], firsts_[region + 1] - firsts_[region]);
  }
  std::unique_ptr<RegionElimination<Dim>> linearised(std::size_t region);
  /// Eliminates a region and writes its Schur complement.
  void eliminate(std::size_t region, DenseBlock schur_complement);
  void eliminate_all(double damping);
  /// Calls f(first row among what this rank's regions share, first entry in the region's forward(), rows) for each of its
  /// faces.
  template <typename F>
  void for_each_face(std::size_t region, F&& f) const {
    const std::vector<Column>& faces = interface_.borders[region].faces;
    Eigen::Index entry = firsts_[region + 1] - firsts_[region];
    for (auto face = faces.rbegin(); face != faces.rend(); ++face) {
      const Eigen::Index size = interface_.faces.dof(*face);
      f(interface_.faces.offsets[*face], entry -= size, size);
    }
  }

  const Communicator& comm_;
  const std::vector<Region<Dim>>& regions_;
  Interface interface_;
  std::vector<Values<Dim>> estimates_;
  std::vector<Values<Dim>> candidates_;
  std::vector<Eigen::Index> firsts_;  // begin of each region in vectors, and the end
  SharedEntries shared_;
  std::vector<std::vector<PoseOrFeature>> orders_;
  std::vector<Eliminated> eliminated_;
  std::vector<GivenFront> fronts_;  // one for each region with a border
  RegionSolver solver_;             // for what the regions share
  Eigen::VectorXd gradient_;
  Eigen::VectorXd diagonal_;
  Eigen::VectorXd solution_;
  double damping_ = 0.0;
  std::int64_t largest_bytes_ = 0;  // of the largest factors, as many as are held at a time
  bool is_curved_ = false;
  bool is_factorised_ = false;
  bool is_solved_ = false;
  bool is_singular_ = false;
};

}  // namespace mapjoin::distributed
