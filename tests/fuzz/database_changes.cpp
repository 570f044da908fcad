#include "database_changes.hpp"

#include <hdf5.h>

#include <phynness/formats/hash.hpp>
#include <phynness/formats/mesh.hpp>

namespace phynness::fuzz {
namespace {

constexpr const char* datasets[] = {"/scene",
                                    "/mesh/nodes",
                                    "/mesh/cells",
                                    "/mesh/surface",
                                    "/mesh/groups/0",
                                    "/sets/fixed",
                                    "/sets/active",
                                    "/sets/output",
                                    "/directions",
                                    "/magnitudes",
                                    "/responses/status",
                                    "/responses/force",
                                    "/responses/energy",
                                    "/responses/displacement",
                                    "/responses/tangent",
                                    "/responses/negative_pivots",
                                    "/responses/iterations",
                                    "/responses/cutbacks",
                                    "/responses/min_jacobian",
                                    "/responses/seconds",
                                    "/responses/end_reason",
                                    "/responses/end_depth",
                                    "/responses/fold_depth",
                                    "/responses/energy_lost",
                                    "/responses/fields/von-mises-stress"};
constexpr const char* groups[] = {"/mesh", "/mesh/groups", "/sets", "/responses"};
constexpr const char* attributes[] = {"format",   "format_minor",           "format_version", "software_version",
                                      "complete", "physics_hash",           "mesh_hash",      "tangents",
                                      "fields",   "displacement_precision", "scene_name",     "scene_folder",
                                      "name"};
constexpr std::int64_t integers[] = {0,    1,          2,          -1,          7,     8,         100, 127,
                                     -128, 2147483647, 2147483648, -2147483648, 65536, 1LL << 40, 255, -5};

/// Closes what it holds; negative ids are HDF5's own refusals and are passed on as they are.
struct Id {
  hid_t id = -1;
  explicit Id(hid_t from) : id(from) {}
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  ~Id() {
    if (id < 0) return;
    const auto kind = H5Iget_type(id);
    if (kind == H5I_FILE)
      H5Fclose(id);
    else if (kind == H5I_DATATYPE)
      H5Tclose(id);
    else if (kind == H5I_DATASPACE)
      H5Sclose(id);
    else if (kind == H5I_ATTR)
      H5Aclose(id);
    else if (kind == H5I_GENPROP_LST)
      H5Pclose(id);
    else
      H5Oclose(id);
  }
  operator hid_t() const { return id; }
};

template <std::size_t n>
const char* any(const char* const (&names)[n], Script& script) {
  return names[static_cast<std::size_t>(script.below(n))];
}
std::int64_t integer(Script& script) {
  const int kind = script.byte();
  if (kind < 192) return integers[static_cast<std::size_t>(kind) % std::size(integers)];
  return script.raw<std::int32_t>();
}
hid_t any_type(Script& script) {
  const hid_t plain[] = {H5T_STD_I32LE, H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_I64BE, H5T_STD_U8LE, H5T_STD_REF_OBJ};
  const auto text = [](std::size_t size) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, size);
    return type;
  };
  const hsize_t three = 3;
  const std::int32_t one = 1;
  hid_t type = -1;
  switch (const int kind = script.below(12)) {
    case 6:
      return text(1 + static_cast<std::size_t>(script.byte()));
    case 7:
      type = H5Tcreate(H5T_COMPOUND, 16);
      H5Tinsert(type, "a", 0, H5T_IEEE_F64LE);
      H5Tinsert(type, "b", 8, H5T_STD_I32LE);
      return type;
    case 8:
      type = H5Tenum_create(H5T_STD_I32LE);
      H5Tenum_insert(type, "one", &one);
      return type;
    case 9:
      return H5Tarray_create2(H5T_IEEE_F64LE, 1, &three);
    case 10:
      return H5Tvlen_create(H5T_STD_I32LE);
    case 11:
      return text(H5T_VARIABLE);
    default:
      return H5Tcopy(plain[kind]);
  }
}
hid_t any_space(Script& script) {
  constexpr hsize_t extents[] = {0, 1, 2, 3, 4, 6, 7, 1000, 1 << 20, 1'000'000'000, 1'000'000'000'000};
  const int rank = script.below(7);
  if (rank == 6) return H5Screate(H5S_NULL);
  if (rank == 0) return H5Screate(H5S_SCALAR);
  hsize_t shape[5];
  for (int k = 0; k < rank; ++k)
    shape[k] = extents[static_cast<std::size_t>(script.below(static_cast<int>(std::size(extents))))];
  return H5Screate_simple(rank, shape, nullptr);
}

/// Writes zeros of any type but those of variable length, where the values fit in memory.
template <class Write>
void write_zeros(hid_t type, hid_t space, const Write& write) {
  const auto n = H5Sget_simple_extent_npoints(space);
  constexpr hssize_t most = 1 << 16;
  if (n <= 0 || n > most || H5Tdetect_class(type, H5T_VLEN) > 0 || H5Tis_variable_str(type) > 0) return;
  const std::vector<unsigned char> zeros(static_cast<std::size_t>(n) * H5Tget_size(type), 0);
  write(zeros.data());
}

/// Reading or writing one that is made of itself, HDF5 calls itself until the stack is used up.
bool is_virtual(hid_t set) {
  const Id properties(H5Dget_create_plist(set));
  return H5Pget_layout(properties) == H5D_VIRTUAL;
}

void change_values(hid_t file, Script& script) {
  const Id set(H5Dopen2(file, any(datasets, script), H5P_DEFAULT));
  if (set < 0 || is_virtual(set)) return;
  const Id type(H5Dget_type(set)), space(H5Dget_space(set));
  const auto n = H5Sget_simple_extent_npoints(space);
  const std::size_t size = H5Tget_size(type);
  const auto kind = H5Tget_class(type);
  constexpr hssize_t most = 1 << 16;
  if ((kind != H5T_INTEGER && kind != H5T_FLOAT) || n <= 0 || n > most) return;
  std::vector<unsigned char> bytes(static_cast<std::size_t>(n) * size);
  if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) return;
  const bool all = script.below(8) == 0;
  const std::size_t first = all ? 0 : script.raw<std::uint16_t>() % static_cast<std::size_t>(n);
  const auto put = [&](const auto& value) {
    for (std::size_t i = first; i < (all ? static_cast<std::size_t>(n) : first + 1); ++i)
      std::memcpy(&bytes[i * size], &value, std::min(size, sizeof value));
  };
  if (kind == H5T_INTEGER)
    put(integer(script));
  else if (size == sizeof(float))
    put(std::bit_cast<float>(script.raw<std::uint32_t>()));
  else
    put(script.number());
  H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data());
}

void change_attribute(hid_t file, Script& script) {
  const char* name = any(attributes, script);
  const char* owner = std::strcmp(name, "name") == 0 ? "/mesh/groups/0" : "/";
  const Id object(H5Oopen(file, owner, H5P_DEFAULT));
  if (object < 0) return;
  H5Adelete(object, name);
  const int how = script.below(4);
  if (how == 0) {  // a number
    const Id space(H5Screate(H5S_SCALAR));
    const Id attribute(H5Acreate2(object, name, H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT));
    const std::int64_t value = integer(script);
    H5Awrite(attribute, H5T_NATIVE_INT64, &value);
  } else if (how < 3) {  // a text
    const Id type(H5Tcopy(H5T_C_S1)), space(H5Screate(H5S_SCALAR));
    std::string text;
    for (int n = script.below(32); n > 0; --n) text += static_cast<char>(script.byte());
    H5Tset_size(type, how == 1 ? H5T_VARIABLE : text.size() + 1);
    const Id attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
    const char* value = text.c_str();
    H5Awrite(attribute, type, how == 1 ? static_cast<const void*>(&value) : value);
  } else {  // anything
    const Id type(any_type(script)), space(any_space(script));
    // HDF5 makes room for all values of an attribute at once, without asking whether there is that much.
    constexpr hssize_t most = 4096;
    if (H5Sget_simple_extent_npoints(space) > most) return;
    const Id attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
    if (attribute >= 0) write_zeros(type, space, [&](const void* v) { H5Awrite(attribute, type, v); });
  }
}

/// Another dataset in the place of one, of any type, shape and storage.
void replace_dataset(hid_t file, Script& script) {
  const char* name = any(datasets, script);
  hid_t own_type = -1, own_space = -1;
  if (const Id old(H5Dopen2(file, name, H5P_DEFAULT)); old >= 0) {
    own_type = H5Dget_type(old);
    own_space = H5Dget_space(old);
  }
  const int keeps = script.below(3);
  const Id type(keeps == 1 && own_type >= 0 ? H5Tcopy(own_type) : any_type(script));
  const Id space(keeps == 2 && own_space >= 0 ? H5Scopy(own_space) : any_space(script));
  if (own_type >= 0) H5Tclose(own_type);
  if (own_space >= 0) H5Sclose(own_space);
  H5Ldelete(file, name, H5P_DEFAULT);
  const Id properties(H5Pcreate(H5P_DATASET_CREATE));
  const int rank = H5Sget_simple_extent_ndims(space), storage = script.below(6);
  if (rank > 0 && storage < 3) {
    hsize_t chunk[5];
    for (int k = 0; k < rank; ++k) chunk[k] = 1 + static_cast<hsize_t>(script.below(8));
    H5Pset_chunk(properties, rank, chunk);
    if (storage > 0) H5Pset_deflate(properties, 1);
    if (storage > 1) H5Pset_scaleoffset(properties, H5Z_SO_INT, 0);
  } else if (storage == 3) {
    H5Pset_external(properties, "/etc/hostname", 0, H5F_UNLIMITED);
  } else if (storage == 4) {
    H5Pset_virtual(properties, space, ".", "/mesh/nodes", space);
  }
  const Id set(H5Dcreate2(file, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT));
  // Nothing through the filter scaleoffset, whose code in HDF5 1.10 reads beyond what it was given.
  if (set < 0 || storage > 1) return;
  write_zeros(type, space, [&](const void* v) { H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, v); });
}

void change_links(hid_t file, Script& script) {
  const int how = script.below(6);
  const char* name = how == 5 ? any(groups, script) : any(datasets, script);
  const char* other = any(datasets, script);
  if (how == 1) {
    H5Ldelete(file, other, H5P_DEFAULT);
    H5Lmove(file, name, file, other, H5P_DEFAULT, H5P_DEFAULT);
    return;
  }
  H5Ldelete(file, name, H5P_DEFAULT);
  if (how == 2) H5Lcreate_soft(other, file, name, H5P_DEFAULT, H5P_DEFAULT);
  if (how == 3) H5Lcreate_external("other.h5", other, file, name, H5P_DEFAULT, H5P_DEFAULT);
  if (how == 4) H5Lcreate_hard(file, other, file, name, H5P_DEFAULT, H5P_DEFAULT);
  if (how == 5) H5Lcreate_hard(file, "/directions", file, name, H5P_DEFAULT, H5P_DEFAULT);
  if (how == 0 && script.below(2) == 0) {
    const Id group(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  }
}

}  // namespace

void change_objects(const std::filesystem::path& path, Script& script) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Id file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
  constexpr int most = 8;
  for (int n = 0; file >= 0 && n < most && !script.at_end(); ++n) {
    const int kind = script.below(8);
    if (kind < 4)
      change_values(file, script);
    else if (kind < 6)
      change_attribute(file, script);
    else if (kind == 6)
      replace_dataset(file, script);
    else
      change_links(file, script);
  }
}

void seal_mesh(const std::filesystem::path& path) {
  const Id file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
  Fnv1a64 hash;
  for (const char* name : {"/mesh/nodes", "/mesh/cells"}) {
    const Id set(file >= 0 ? H5Dopen2(file, name, H5P_DEFAULT) : -1);
    if (set < 0 || is_virtual(set)) return;
    const Id type(H5Dget_type(set)), space(H5Dget_space(set));
    const auto n = H5Sget_simple_extent_npoints(space);
    const auto kind = H5Tget_class(type);
    constexpr hssize_t most = 1 << 16;
    if (n < 0 || n > most || (kind != H5T_INTEGER && kind != H5T_FLOAT)) return;
    std::vector<unsigned char> bytes(static_cast<std::size_t>(n) * H5Tget_size(type));
    if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) return;
    hash.add(bytes.data(), bytes.size());
  }
  const Id attribute(H5Aopen(file, "mesh_hash", H5P_DEFAULT)), type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const std::string text = hash.hex();
  const char* value = text.c_str();
  const Id found(attribute >= 0 ? H5Aget_type(attribute) : -1);
  if (found >= 0 && H5Tis_variable_str(found) > 0) {
    const Id space(H5Aget_space(attribute));
    if (H5Sget_simple_extent_npoints(space) == 1) H5Awrite(attribute, type, &value);
  }
}

void seal_log(std::vector<std::uint8_t>& log, std::size_t record_bytes) {
  constexpr std::size_t opening_bytes = 72, checksum_bytes = 8;
  for (std::size_t at = opening_bytes; at + record_bytes <= log.size(); at += record_bytes) {
    Fnv1a64 hash;
    hash.add(log.data(), opening_bytes);
    hash.add(&log[at], record_bytes - checksum_bytes);
    const std::uint64_t value = hash.value();
    std::memcpy(&log[at + record_bytes - checksum_bytes], &value, sizeof value);
  }
}

}  // namespace phynness::fuzz
