// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/hdf5_facts.hpp"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

namespace volute {
namespace {

/// Whatever HDF5 counts references of.
class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}

  ~Hdf5Handle() {
    if (id_ >= 0)
      close_(id_);
  }

  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;

  hid_t id() const { return id_; }

  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Negative for a file of another kind.
hid_t openHdf5(const std::string& file) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || H5Fis_hdf5(file.c_str()) <= 0)
    return -1;
  return H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
}

herr_t noteLink(hid_t group, const char* name, const H5L_info_t* info, void* links) {
  constexpr std::size_t kMax = 1000, kMaxText = std::size_t{1} << 16;
  auto& all = *static_cast<std::vector<Hdf5Link>*>(links);
  if (info->type != H5L_TYPE_EXTERNAL)
    return 0;
  if (all.size() >= kMax)
    return 1;
  std::string value(std::min(info->u.val_size, kMaxText), '\0');
  const char *file = nullptr, *object = nullptr;
  unsigned flags = 0;
  if (H5Lget_val(group, name, value.data(), value.size(), H5P_DEFAULT) >= 0 &&
      H5Lunpack_elink_val(value.data(), value.size(), &flags, &file, &object) >= 0)
    all.push_back({name, std::string(file) + ":" + object});
  return 0;
}

/// How Python reads it, whose HDF5 opens other files and loads filters.
std::string inPython(const std::string& file, const std::string& name) {
  return fmt::format(
      "let Python read it: volute.compress(h5py.File(\"{}\")[\"{}\"], \"{}.volute\")", file, name,
      std::filesystem::path(file).stem().string());
}

/// An error where a dataset is put together from other files, or has its bytes there.
Status checkPlace(hid_t properties, const std::string& file, const std::string& name) {
  constexpr std::size_t kMaxText = 1024;
  std::string first;
  std::size_t others = 0;
  const auto note = [&](const char* source) {
    if (first.empty())
      first = source;
    else if (first != source)
      ++others;
  };
  const bool isVirtual = H5Pget_layout(properties) == H5D_VIRTUAL;
  if (isVirtual) {
    std::size_t count = 0;
    H5Pget_virtual_count(properties, &count);
    for (std::size_t i = 0; i < count; ++i) {
      std::array<char, kMaxText> source{};
      if (H5Pget_virtual_filename(properties, i, source.data(), source.size()) > 0 &&
          std::string_view(source.data()) != ".")  // the file itself
        note(source.data());
    }
  }
  for (int i = 0; i < std::max(0, H5Pget_external_count(properties)); ++i) {
    std::array<char, kMaxText> source{};
    if (H5Pget_external(properties, static_cast<unsigned>(i), source.size() - 1, source.data(),
                        nullptr, nullptr) >= 0)
      note(source.data());
  }
  if (first.empty())
    return {};
  return fail(ErrorCode::kUnsupported,
              "{}: '{}' {} {}{}, and no other file is read with this one; {}{}", file, name,
              isVirtual ? "is a virtual dataset over" : "has its numbers in", first,
              others > 0 ? fmt::format(" and {} more", others) : "",
              isVirtual && others == 0 ? "give that one, or " : "", inPython(file, name));
}

/// Which filter of its chunks is not here; empty: all are.
std::string lackingFilter(hid_t properties, const std::string& file, const std::string& name) {
  for (int i = 0; i < std::max(0, H5Pget_nfilters(properties)); ++i) {
    unsigned flags = 0, settings = 0;
    std::size_t count = 0;
    std::array<char, 64> title{};
    const H5Z_filter_t filter = H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &count,
                                               nullptr, title.size() - 1, title.data(), &settings);
    if (filter < 0 || H5Zfilter_avail(filter) > 0)
      continue;
    const std::string known(title.data());
    return fmt::format(
        "'{}' is packed by the HDF5 filter {}{}, which is not here; install it where HDF5 looks "
        "for "
        "filters (the environment's HDF5_PLUGIN_PATH), unpack it with h5repack -f NONE, or {}",
        name, filter, known.empty() ? "" : " (" + known + ")", inPython(file, name));
  }
  return {};
}

std::string fillOf(hid_t dataset, hid_t properties) {
  H5D_fill_value_t stated = H5D_FILL_VALUE_UNDEFINED;
  H5D_fill_time_t when = H5D_FILL_TIME_ERROR;
  double value = 0;
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.id());
  if (H5Pfill_value_defined(properties, &stated) < 0 || stated == H5D_FILL_VALUE_UNDEFINED ||
      H5Pget_fill_time(properties, &when) < 0 || when == H5D_FILL_TIME_NEVER ||
      (kind != H5T_INTEGER && kind != H5T_FLOAT) ||
      H5Pget_fill_value(properties, H5T_NATIVE_DOUBLE, &value) < 0)
    return {};
  return fmt::format("{:g}", value);
}

}  // namespace

std::vector<Hdf5Link> hdf5Links(const std::string& file) {
  std::vector<Hdf5Link> links;
  if (const Hdf5Handle opened(openHdf5(file), H5Fclose); opened)
    H5Lvisit(opened.id(), H5_INDEX_NAME, H5_ITER_NATIVE, noteLink, &links);
  return links;
}

Result<Hdf5Chunks> hdf5Chunks(const std::string& file, const std::string& name) {
  Hdf5Chunks chunks;
  const Hdf5Handle opened(openHdf5(file), H5Fclose);
  if (!opened)
    return chunks;
  const Hdf5Handle dataset(H5Dopen2(opened.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset)
    return chunks;
  const Hdf5Handle properties(H5Dget_create_plist(dataset.id()), H5Pclose);
  const Hdf5Handle space(H5Dget_space(dataset.id()), H5Sclose);
  const std::string bare = name.starts_with('/') ? name.substr(1) : name;
  VOLUTE_TRY(checkPlace(properties.id(), file, bare));
  const H5D_layout_t layout = H5Pget_layout(properties.id());
  if (layout == H5D_CONTIGUOUS) {
    chunks.expected = 1;
    chunks.absent = H5Dget_storage_size(dataset.id()) == 0 ? 1 : 0;
  } else if (layout == H5D_CHUNKED) {
    std::array<hsize_t, H5S_MAX_RANK> sizes{}, sides{};
    const int rank = H5Sget_simple_extent_ndims(space.id());
    hsize_t there = 0;
    if (rank < 1 || H5Sget_simple_extent_dims(space.id(), sizes.data(), nullptr) != rank ||
        H5Pget_chunk(properties.id(), rank, sides.data()) != rank ||
        H5Dget_num_chunks(dataset.id(), space.id(), &there) < 0)
      return chunks;
    chunks.expected = 1;
    for (std::size_t i = 0; std::cmp_less(i, rank); ++i) {
      const hsize_t side = std::max<hsize_t>(sides[i], 1);
      const hsize_t along = sizes[i] / side + (sizes[i] % side != 0 ? 1 : 0);
      if (__builtin_mul_overflow(chunks.expected, along, &chunks.expected))
        return Hdf5Chunks();
    }
    chunks.absent = chunks.expected - std::min<std::uint64_t>(there, chunks.expected);
    if (there > 0)
      chunks.lacks = lackingFilter(properties.id(), file, bare);
  }
  if (chunks.absent > 0)
    chunks.fill = fillOf(dataset.id(), properties.id());
  return chunks;
}

}  // namespace volute
