// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/file_bytes.hpp>
#include <mapjoin/io/text_scanner.hpp>
#include <mapjoin/io/tum_reader.hpp>

namespace mapjoin {

Expected<std::vector<StampedPose>> read_tum(const std::filesystem::path& path) {
  const auto bytes = FileBytes::read(path);
  if (!bytes) return tl::unexpected(bytes.error());
  TextScanner text(path.string(), bytes->view());
  std::vector<StampedPose> poses;
  while (text.next_line()) {
    const double time = text.number();
    const Point<3> translation = text.vector<3>();
    Eigen::Quaterniond q(text.vector<4>());  // x, y, z, w
    const double largest = q.coeffs().cwiseAbs().maxCoeff();
    if (largest == 0.0) text.reject("this quaternion is zero");
    q.coeffs() /= largest;  // Its square may be more than a double holds.
    if (auto whole = text.finish_line(); !whole) return tl::unexpected(whole.error());
    poses.push_back({time, {translation, Rotation<3>(q.normalized())}});
  }
  return poses;
}

}  // namespace mapjoin
