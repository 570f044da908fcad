// Claims: mesh.txt comes back bit for bit, whatever the numbers and the locale; damage is refused, each kind
// with its own message.
#include <clocale>
#include <cstring>
#include <limits>
#include <phynness/formats/hash.hpp>

#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

Mesh awkward_mesh() {
  Mesh mesh;
  mesh.nodes.resize(5, 3);
  mesh.nodes << -0.0, 0.0, 0.1, 1.0 / 3, std::numeric_limits<double>::denorm_min(), -std::numeric_limits<double>::min(),
      1, std::numeric_limits<double>::max(), -1e-300, 3, -5e-324, 1e22, 0.1 + 0.2, 123456789.123456789, 2;
  mesh.cells.resize(2, 4);
  mesh.cells << 0, 1, 2, 3, 1, 4, 2, 3;
  mesh.surface = boundary_triangles(mesh.cells);
  mesh.groups["a name with spaces"] = {1, 3};
  mesh.groups["7"] = {0};
  mesh.regions = {0, 255};
  return mesh;
}

void expect_same(const Mesh& a, const Mesh& b) {
  ASSERT_EQ(a.nodes.rows(), b.nodes.rows());
  EXPECT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), sizeof(double) * static_cast<std::size_t>(a.nodes.size())), 0);
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.surface, b.surface);
  EXPECT_EQ(a.groups, b.groups);
  EXPECT_EQ(a.regions, b.regions);
}

TEST(MeshText, RoundTripsBitForBit) {
  Mesh mesh = awkward_mesh();
  for (const bool regions : {true, false}) {
    if (!regions) mesh.regions.clear();
    const std::string text = write_mesh_text(mesh);
    EXPECT_EQ(text.find("regions") != std::string::npos, regions);
    const Mesh back = read_mesh_text(text, "mesh.txt");
    expect_same(mesh, back);
    EXPECT_EQ(write_mesh_text(back), text);
    EXPECT_EQ(mesh_hash(back), mesh_hash(mesh));
  }
}

TEST(MeshText, FixedNodesOfOtherProgramsAreRead) {
  std::string body = write_mesh_text(awkward_mesh());
  body.erase(body.find("checksum "));
  body.replace(body.find("fixed 0\n"), 8, "fixed 2\n0\n4\n");
  expect_same(awkward_mesh(), read_mesh_text(body + "checksum " + hash_of(body) + "\n", "mesh.txt"));
}

TEST(MeshText, DoesNotCareAboutTheLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  bool found = false;
  for (const char* locale : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "nl_NL.UTF-8"})
    found = found || std::setlocale(LC_ALL, locale) != nullptr;
  std::string folder = "/tmp/phynness-locale-XXXXXX";
  if (!found && ::mkdtemp(folder.data())) {  // made here, from the sources of package locales
    const std::string command = "localedef -i de_DE -f UTF-8 " + folder + "/de_DE.UTF-8 > /dev/null 2>&1";
    if (std::system(command.c_str()) == 0) {
      ::setenv("LOCPATH", folder.c_str(), 1);
      found = std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr;
      ::unsetenv("LOCPATH");
    }
    std::filesystem::remove_all(folder);
  }
  const std::string text = write_mesh_text(awkward_mesh());
  const Mesh back = read_mesh_text(text, "mesh.txt");
  std::setlocale(LC_ALL, before.c_str());
  expect_same(awkward_mesh(), back);
  EXPECT_EQ(text, write_mesh_text(awkward_mesh()));
  if (!found) GTEST_SKIP() << "no locale with a decimal comma; tools/install-deps --tests installs what makes one";
}

TEST(MeshText, EveryTruncationIsRefused) {
  const std::string text = write_mesh_text(awkward_mesh());
  for (std::size_t n = 0; n < text.size(); ++n)
    EXPECT_NE(error_of([&] { read_mesh_text(text.substr(0, n), "mesh.txt"); }), "") << n << " bytes";
  EXPECT_TRUE(contains(error_of([&] { read_mesh_text(text.substr(0, text.size() / 2), "mesh.txt"); }), "truncated"));
}

TEST(MeshText, EveryChangedByteIsRefused) {
  const std::string text = write_mesh_text(awkward_mesh());
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    EXPECT_NE(error_of([&] { read_mesh_text(changed, "mesh.txt"); }), "") << "byte " << i;
  }
}

TEST(MeshText, EachKindOfDamageHasItsOwnMessage) {
  const std::string text = write_mesh_text(awkward_mesh());
  std::string corrupted = text, versioned = text;
  corrupted[text.size() / 2] ^= 1;
  versioned.replace(versioned.find(" 1\n"), 3, " 2\n");
  EXPECT_TRUE(contains(error_of([&] { read_mesh_text(corrupted, "m"); }), "corrupted"));
  EXPECT_TRUE(
      contains(error_of([&] { read_mesh_text(versioned, "m"); }), "another version of the format: phynness-mesh 2"));
  EXPECT_TRUE(contains(error_of([&] { read_mesh_text("solid x\n", "m"); }), "not a phynness mesh"));
  EXPECT_TRUE(contains(error_of([&] { read_mesh_text("", "m"); }), "not a phynness mesh"));
}

TEST(MeshHash, KnowsNodesAndCellsApartFromTheRest) {
  const Mesh mesh = awkward_mesh();
  Mesh other = mesh;
  other.groups.clear();
  EXPECT_EQ(mesh_hash(mesh), mesh_hash(other));
  other.nodes(0, 0) = 0.0;  // was negative zero: other bits, another mesh
  EXPECT_NE(mesh_hash(mesh), mesh_hash(other));
  other = mesh;
  std::swap(other.cells(0, 0), other.cells(0, 1));
  EXPECT_NE(mesh_hash(mesh), mesh_hash(other));
}

}  // namespace
}  // namespace phynness::test
