// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/system_call.hpp>
#include <utility>

namespace mapjoin {
namespace {

constexpr std::string_view kGzipMagic = "\x1f\x8b";

tl::unexpected<Error> cannot_read(const std::filesystem::path& path, int reason) {
  return call_failed(path, reason, ErrorKind::kBadInput);
}

tl::unexpected<Error> too_large(const std::filesystem::path& path, std::size_t most) {
  return tl::unexpected(Error{ErrorKind::kTooLarge, fmt::format("{}: unpacks to more than {} MB", path.string(), most >> 20)});
}

/// Makes room for more bytes behind the first `used`: doubles the size, up to one byte beyond `most`, which shows an excess.
void grow(std::string& bytes, std::size_t used, std::size_t most) {
  constexpr std::size_t kFirst = std::size_t{1} << 16;
  if (used == bytes.size()) bytes.resize(std::min(std::max(kFirst, 2 * used), most + 1));
}

/// The bytes of the pipe `path`, read to its end.
Expected<std::string> drain(const std::filesystem::path& path, int descriptor, std::size_t most) {
  std::string bytes;
  std::size_t used = 0;
  while (used <= most) {
    grow(bytes, used, most);
    const ::ssize_t got = ::read(descriptor, bytes.data() + used, bytes.size() - used);
    if (got < 0) return cannot_read(path, errno);
    if (got == 0) {
      bytes.resize(used);
      return bytes;
    }
    used += static_cast<std::size_t>(got);
  }
  return too_large(path, most);
}

/// The content of the gzip file `path` of one or more members.
Expected<std::string> gunzip(const std::filesystem::path& path, std::string_view packed, std::size_t most) {
  const auto wrong = [&](std::string_view what) { return bad_input(fmt::format("{}: {}", path.string(), what)); };
  std::string bytes;
  do {
    if (packed.substr(0, 2) != kGzipMagic) return wrong("bytes follow the end of the gzip stream");
    const Inflated end = append_inflated(Wrapping::kGzip, packed, most, bytes);
    if (end == Inflated::kTooLarge) return too_large(path, most);
    if (end == Inflated::kCutOff) return wrong("the gzip stream is cut off");
    if (end == Inflated::kDamaged) return wrong("the gzip stream is damaged");
    // Tapes are filled up with zeros; gzip passes over them, too.
  } while (packed.find_first_not_of('\0') != packed.npos);
  return bytes;
}

/// The beginning of files, and what packed them so.
using Packer = std::pair<std::string_view, std::string_view>;
constexpr auto kPackedOtherwise =
    std::to_array<Packer>({{"\3757zXZ", "xz"}, {"BZh", "bzip2"}, {"\x28\xb5\x2f\xfd", "zstd"}, {"PK\3\4", "zip"}});

}  // namespace

Inflated append_inflated(Wrapping wrapping, std::string_view& packed, std::size_t most, std::string& bytes) {
  constexpr int kGzipHeader = 16;
  constexpr std::size_t kMostAtOnce = std::numeric_limits<uInt>::max();
  z_stream stream{};
  if (inflateInit2(&stream, MAX_WBITS + (wrapping == Wrapping::kGzip ? kGzipHeader : 0)) != Z_OK) return Inflated::kTooLarge;
  std::size_t used = bytes.size();
  int status = Z_OK;
  while ((status == Z_OK || (status == Z_BUF_ERROR && !packed.empty())) && used <= most) {
    grow(bytes, used, most);
    const auto in = static_cast<uInt>(std::min(packed.size(), kMostAtOnce));
    const auto out = static_cast<uInt>(std::min(bytes.size() - used, kMostAtOnce));
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));  // zlib reads only.
    stream.avail_in = in;
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data() + used);
    stream.avail_out = out;
    status = inflate(&stream, Z_NO_FLUSH);
    packed.remove_prefix(in - stream.avail_in);
    used += out - stream.avail_out;
  }
  inflateEnd(&stream);
  bytes.resize(used);
  if (used > most) return Inflated::kTooLarge;
  if (status == Z_STREAM_END) return Inflated::kWhole;
  return status == Z_BUF_ERROR ? Inflated::kCutOff : Inflated::kDamaged;
}

FileBytes FileBytes::of(std::string bytes) {
  auto owner = std::make_shared<const std::string>(std::move(bytes));
  const std::string_view view = *owner;
  return {std::move(owner), view};
}

Expected<FileBytes> FileBytes::of_member(const std::filesystem::path& path, std::string_view content,
                                         std::size_t most_unpacked) {
  if (content.substr(0, 2) != kGzipMagic) return FileBytes(nullptr, content);
  return gunzip(path, content, most_unpacked).map(of);
}

Expected<FileBytes> FileBytes::read(const std::filesystem::path& path, std::size_t most_unpacked) {
  const Descriptor file = Descriptor::to_read(path);
  struct stat status {};
  if (file.value() < 0 || ::fstat(file.value(), &status) != 0) return cannot_read(path, errno);
  if (S_ISDIR(status.st_mode)) return cannot_read(path, EISDIR);

  FileBytes bytes(nullptr, {});
  if (!S_ISREG(status.st_mode)) {
    auto drained = drain(path, file.value(), most_unpacked);
    if (!drained) return tl::unexpected(drained.error());
    bytes = of(*std::move(drained));
  } else if (status.st_size > 0) {
    const auto size = static_cast<std::size_t>(status.st_size);
    void* const data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.value(), 0);
    if (data == MAP_FAILED) return cannot_read(path, errno);
    ::madvise(data, size, MADV_SEQUENTIAL);
    const auto unmap = [size](const void* mapped) { ::munmap(const_cast<void*>(mapped), size); };
    bytes = {std::shared_ptr<const void>(data, unmap), {static_cast<const char*>(data), size}};
  }
  if (bytes.view().substr(0, 2) == kGzipMagic) {
    auto unpacked = of_member(path, bytes.view(), most_unpacked);
    if (!unpacked) return unpacked;
    bytes = *std::move(unpacked);
  }
  for (const auto& [begin, packer] : kPackedOtherwise) {
    if (bytes.view().starts_with(begin))
      return bad_input(fmt::format("{}: is packed by {}; unpack it, or pack it by gzip", path.string(), packer));
  }
  if (bytes.view().empty()) return bad_input(fmt::format("{}: the file is empty", path.string()));
  return bytes;
}

}  // namespace mapjoin
