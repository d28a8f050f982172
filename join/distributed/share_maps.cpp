// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/localmap/build.hpp>
#include <utility>

namespace mapjoin::distributed {

template <int Dim>
Expected<ShareMaps<Dim>> built_maps(const LogShare<Dim>& share, const RunOptions& options) {
  Split parts = split(share.log, options.split, share.is_referenced);
  return build_local_maps(share.log, parts, {options.solver, nullptr}).map([&](LocalMaps<Dim> built) {
    return ShareMaps<Dim>{std::move(parts), std::move(built.maps), built.iterations};
  });
}

template Expected<ShareMaps<2>> built_maps(const LogShare<2>&, const RunOptions&);
template Expected<ShareMaps<3>> built_maps(const LogShare<3>&, const RunOptions&);

}  // namespace mapjoin::distributed
