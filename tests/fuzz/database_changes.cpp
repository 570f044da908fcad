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
constexpr const char* attributes[] = {
    "format",   "format_version", "software_version",       "complete",   "physics_hash", "mesh_hash",
    "tangents", "fields",         "displacement_precision", "scene_name", "scene_folder", "name"};
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
void change_values(hid_t file, Script& script) {
  const Id set(H5Dopen2(file, any(datasets, script), H5P_DEFAULT));
  if (set < 0) return;
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
  const Id space(H5Screate(H5S_SCALAR));
  if (script.below(2) == 0) {  // a number
    const Id attribute(H5Acreate2(object, name, H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT));
    const std::int64_t value = integer(script);
    H5Awrite(attribute, H5T_NATIVE_INT64, &value);
  } else {  // a text
    const Id type(H5Tcopy(H5T_C_S1));
    std::string text;
    for (int n = script.below(32); n > 0; --n) text += static_cast<char>(script.byte());
    H5Tset_size(type, text.size() + 1);
    const Id attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
    H5Awrite(attribute, type, text.c_str());
  }
}

}  // namespace

void change_objects(const std::filesystem::path& path, Script& script) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Id file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
  constexpr int most = 8;
  for (int n = 0; file >= 0 && n < most && !script.at_end(); ++n) {
    if (script.below(4) < 3)
      change_values(file, script);
    else
      change_attribute(file, script);
  }
}

void seal_mesh(const std::filesystem::path& path) {
  const Id file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
  Fnv1a64 hash;
  for (const char* name : {"/mesh/nodes", "/mesh/cells"}) {
    const Id set(file >= 0 ? H5Dopen2(file, name, H5P_DEFAULT) : -1);
    if (set < 0) return;
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
