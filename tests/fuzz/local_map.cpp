// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/local_maps/local_map_file.hpp>
#include <tests/fuzz/folder.hpp>
#include <tests/fuzz/local_map.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {

void check_local_map(const char* name, std::string_view bytes, LocalMapFormat written) {
  // Most inputs are no map; to find that without a folder is faster.
  if (const auto file = parse_local_map(name, bytes); !file) return check_error(file.error(), name);
  static Folder folder;
  folder.hold({{name, bytes}});
  const auto set = read_local_map_set(folder.path());
  check(set, folder.path());
  if (set) check_round_trip(*set, written);
}

void check_round_trip(const AnySubmapSet& any, LocalMapFormat format) {
  static Folder folder;
  folder.hold({});
  const auto write_and_read = [&]<int Dim>(const SubmapSet<Dim>& set) {
    if (!write_local_maps(set.graph.submaps, set.features, format, folder.path())) return;  // The format cannot hold them.
    const auto read = read_local_map_set(folder.path());
    promise(read.has_value(), "what was written reads back: " + (read ? "" : read.error().message));
    check_maps(*read);
    const bool is_exact = Dim == 2 && format == LocalMapFormat::kText;
    if (is_exact) promise(bits_of(*read) == bits_of(any), "what is written exactly is the same");
  };
  std::visit(write_and_read, any);
}

void local_map_text(std::string_view bytes) {
  check_local_map("localmap_1.txt", bytes, LocalMapFormat::kText);
}

void local_map_mat(std::string_view bytes) {
  check_local_map("localmap_1.mat", bytes, LocalMapFormat::kMat);
}

}  // namespace mapjoin::fuzz
