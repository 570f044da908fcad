// Claim: a body and its surface in all encodings of VTK (ParaView, PyVista) and meshio are the same mesh: node numbers,
// cells and coordinates, bit for bit, because these coordinates are exact in every format. Damaged and unsupported
// files are refused with file and line. Declared sizes need no memory before the data are read.
#include <phynness/formats/vtk.hpp>
#include <random>
#include <set>

#include "mesh_under_test.hpp"
#include "read/raw_mesh.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;

const fs::path formats_folder = fs::path(PHYNNESS_SOURCE_DIR) / "tests/data/meshes/formats";

/// Files of these extensions that are to be read.
std::vector<fs::path> foreign_files(const std::set<std::string>& extensions) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(formats_folder))
    if (extensions.contains(entry.path().extension()) && !entry.path().filename().string().starts_with("refused"))
      found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

std::string bytes_of_file(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

const fs::path& any_body() {
  static const fs::path file = formats_folder / "vtk_ascii.vtu";
  return file;
}

TEST(FilesOfOtherPrograms, HoldTheSameBodyInEveryEncoding) {
  const auto all = foreign_files({".vtu", ".inp"});
  ASSERT_EQ(all.size(), 13u);
  const std::string hash = mesh_hash(import_file(any_body()).mesh);
  for (const auto& file : all) {
    SCOPED_TRACE(file.filename());
    const MeshResult result = import_file(file);
    EXPECT_EQ(mesh_hash(result.mesh), hash);
    ASSERT_EQ(result.mesh.n_nodes(), 27);
    EXPECT_EQ(result.mesh.n_cells(), 48);
    EXPECT_EQ(result.mesh.nodes.row(14), Eigen::RowVector3d(2 / 64.0, 1 / 32.0, 1 / 64.0));
    EXPECT_NEAR(result.quality.volume_m3, 1 / 32.0 * 1 / 16.0 * 1 / 32.0, 1e-18);
    EXPECT_TRUE(result.notes.empty() && result.warnings.empty()) << joined(result.notes) << joined(result.warnings);
  }
}

TEST(FilesOfOtherPrograms, HoldTheSameSurface) {
  const auto all = foreign_files({".ply", ".off"});
  ASSERT_EQ(all.size(), 6u);
  const meshes::RawMesh first = meshes::read_mesh_file(all.front());
  EXPECT_EQ(first.nodes.size(), 26u);
  EXPECT_EQ(first.triangles.size(), 48u);
  for (const auto& file : all) {
    SCOPED_TRACE(file.filename());
    const meshes::RawMesh raw = meshes::read_mesh_file(file);
    EXPECT_EQ(raw.nodes, first.nodes);
    EXPECT_EQ(raw.triangles, first.triangles);
  }
}

TEST(FilesOfOtherPrograms, IncludeThoseOfShow) {
  const Mesh mesh = import_file(any_body()).mesh;
  VtkGrid grid{mesh.nodes, mesh.cells, {}};
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i) grid.node_numbers.push_back(i);
  EXPECT_EQ(mesh_hash(import_bytes(vtu_text(grid, {}), ".vtu").mesh), mesh_hash(mesh));
  EXPECT_EQ(vtu_text(grid, {}).find("CellData"), std::string::npos);
  grid.regions.assign(static_cast<std::size_t>(mesh.n_cells()), 1);
  EXPECT_EQ(mesh_hash(import_bytes(vtu_text(grid, {}), ".vtu").mesh), mesh_hash(mesh));
  EXPECT_NE(vtu_text(grid, {}).find("<CellData>\n        <DataArray type=\"UInt8\" Name=\"region\""),
            std::string::npos);
}

TEST(FilesOfOtherPrograms, AreNotReadWhenCut) {
  for (const auto& file : foreign_files({".vtu", ".ply", ".off"})) {
    const std::string bytes = bytes_of_file(file);
    for (std::size_t n = 0; n + 1 < bytes.size(); n += n + 100 < bytes.size() ? 7 : 1) {
      SCOPED_TRACE(file.filename().string() + " cut to " + std::to_string(n) + " bytes");
      const TemporaryFile cut(bytes.substr(0, n), file.extension());
      // Only a part of the very last number may look whole.
      ASSERT_TRUE(!error_of([&] { meshes::read_mesh_file(cut.path); }).empty() ||
                  contains(joined(meshes::read_mesh_file(cut.path).notes), "without a line break"));
    }
  }
}

TEST(FilesOfOtherPrograms, GiveAnErrorOrASoundMeshWhenDamaged) {
  std::mt19937 random(20111);  // NOLINT: a fixed seed, so that a failure can be repeated
  for (const auto& file : foreign_files({".vtu", ".ply", ".off", ".inp"})) {
    const std::string bytes = bytes_of_file(file);
    for (int n = 0; n < 600; ++n) {
      std::string changed = bytes;
      changed[random() % bytes.size()] = static_cast<char>(random());
      const TemporaryFile damaged(changed, file.extension());
      try {
        const meshes::RawMesh raw = meshes::read_mesh_file(damaged.path);
        for (const auto& cell : raw.tetrahedra)
          for (const std::int32_t node : cell) ASSERT_LT(static_cast<std::size_t>(node), raw.nodes.size());
        for (const auto& triangle : raw.triangles)
          for (const std::int32_t node : triangle) ASSERT_LT(static_cast<std::size_t>(node), raw.nodes.size());
      } catch (const Error&) {  // the other good answer
      }
    }
  }
}

TEST(FilesOfOtherPrograms, WithAnotherCompressorAreRefusedWithARemedy) {
  for (const char* name : {"refused_lz4.vtu", "refused_lzma.vtu"})
    expect_names(error_of([&] { import_file(formats_folder / name); }), {std::string(name) + ":", "zlib"});
}

/// An ASCII grid of one tetrahedron with one text replaced.
std::string changed_vtu(const std::string& from, const std::string& to) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n"
      "<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n"
      "0 0 0 0.1 0 0 0 0.1 0 0 0 0.1\n</DataArray></Points>\n<Cells>\n"
      "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\n"
      "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray>\n"
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray>\n"
      "</Cells></Piece></UnstructuredGrid></VTKFile>\n";
  if (!from.empty()) text.replace(text.find(from), from.size(), to);
  return text;
}

TEST(FilesOfOtherPrograms, HoldIntegersOfAnyWidth) {
  // The length in bytes, 8 as UInt32, and 0 1 2 3 in 16 bits each.
  for (const char* type : {"Int16", "UInt16"}) {
    const auto text =
        changed_vtu("\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3<",
                    std::string("\"") + type + "\" Name=\"connectivity\" format=\"binary\">CAAAAAAAAQACAAMA<");
    EXPECT_EQ(mesh_hash(import_bytes(text, ".vtu").mesh), mesh_hash(import_bytes(changed_vtu("", ""), ".vtu").mesh));
  }
}

TEST(FilesOfOtherPrograms, NameTheDefectOfAnXmlFile) {
  EXPECT_EQ(import_bytes(changed_vtu("", ""), ".vtu").mesh.n_cells(), 1);
  struct Case {
    const char *from, *to;
    std::string part;
  };
  const std::string deep(200000, '<');
  for (const auto& [from, to, part] : {
           Case{"\"4\" Num", "\"999999999999\" Num", ":4: NumberOfPoints"},
           Case{"\"4\" Num", "\"30000000\" Num", "larger than that of any mesh"},
           Case{"\"4\" Num", "\"5\" Num", "12 instead of 15"},
           Case{"NumberOfCells=\"1\"", "NumberOfCells=\"-1\"", ":4: NumberOfCells"},
           Case{">0 1 2 3<", ">0 1 2 4<", ":10: a cell uses a point that is not in the file"},
           Case{">0 1 2 3<", ">0 1 2 -1<", "a cell uses a point"},
           Case{">4<", ">40000001<", "larger than that of any mesh"},
           Case{">4<", ">-4<", "do not ascend"},
           Case{">10<", ">24<", "VTK cell type 24"},
           Case{">10<", ">12<", "is of a type that is not supported"},
           Case{"0.1 0 0 0", "0.1 0 x 0", "expected a number"},
           Case{"0.1 0 0 0", "0.1 0 1e999 0", "expected a number"},
           Case{"Name=\"types\"", "Name=\"kinds\"", "'types' is missing"},
           Case{"LittleEndian", "Middle", "byte_order"},
           Case{"ascii\">10", "appended\" offset=\"0\">", "outside of the appended data"},
           Case{"ascii\">10", "binary\">=!AAAAAA", "not base64"},
           Case{"ascii\">10", "binary\">AQAA", "ends too early"},
           Case{"ascii\">10", "binary\">/////w==", "more than the 1 bytes"},
           Case{"<Points>", deep.c_str(), "XML file"},
           Case{"</VTKFile>", "", "XML file"},
       }) {
    expect_names(import_error(changed_vtu(from, to), ".vtu"), {part});
  }
  EXPECT_TRUE(contains(import_error("<VTKFile></VTKFile>", ".vtu"), "no UnstructuredGrid"));
  EXPECT_TRUE(contains(import_error("\n# vtk DataFile Version 3.0\n", ".vtu"), "XML file"));
  // Entities are not expanded.
  const std::string laughs = changed_vtu("<VTKFile", "<!DOCTYPE a [<!ENTITY a \"&a;&a;\">]><VTKFile");
  EXPECT_EQ(import_bytes(laughs, ".vtu").mesh.n_cells(), 1);
}

TEST(FilesOfOtherPrograms, AreNotUnpackedBeyondWhatTheyDeclare) {
  // A block that says it holds 2 GB where one byte is expected.
  std::string text = changed_vtu("LittleEndian\"", "LittleEndian\" compressor=\"vtkZLibDataCompressor\"");
  text.replace(text.find("ascii\">10"), 9, "binary\">AQAAAAAAAIAAAACACAAAAA==eJxjAAAAAQAB");
  EXPECT_TRUE(contains(import_error(text, ".vtu"), "more than"));
}

TEST(FilesOfOtherPrograms, NameTheDefectOfASurface) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::pair<std::string, const char*> plys[] = {
      {"plum\n", ":1: not a .ply file"},
      {"ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n", "truncated"},
      {"ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n", "no properties"},
      {"ply\nformat middle_endian 1.0\nend_header\n", "unknown format"},
      {"ply\nelement vertex 0\nend_header\n", "no format"},
      {ply + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "not in the file: 3"},
      {ply + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "not in the file"},
      {ply + "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "fewer than three"},
      {ply + "0 0 0\n1 0 0\n0 1 0\n200 0 1 2\n", "truncated"},
      {"ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n3 0 1 2\n",
       "strips"}};
  for (const auto& [bytes, part] : plys) expect_names(import_error(bytes, ".ply"), {part});
  const std::pair<std::string, const char*> offs[] = {
      {"ONE\n", ":1: not an .off file"},
      {"OFF BINARY\n3 1 0\n", "unsupported kind"},
      {"OFF\n4000000000 1 0\n", "truncated"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1\n3 0 1 2\n", ":5: a line is too short"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ":6: a face uses a vertex"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", ":6: a face has fewer"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1000000000000 0 1 2\n", ":6: a line is too short"},
      {"OFF\n3 1 0\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n", "each of which has a line of its own"}};
  for (const auto& [bytes, part] : offs) expect_names(import_error(bytes, ".off"), {part});
}

TEST(FilesOfOtherPrograms, MayHoldColoursNormalsAndComments) {
  const auto corners = [](const std::string& bytes, const char* extension) {
    const TemporaryFile file(bytes, extension);
    return meshes::read_mesh_file(file.path).triangles;
  };
  const std::vector<meshes::Triangle> two{{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(corners("# made by hand\nCOFF 4 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n\n1 1 0 1 0 0 1 # red\n0 1 0 1 0 0 1\n"
                    "4 0 1 2 3 0.5 0.5 0.5\n",
                    ".off"),
            two);
  EXPECT_EQ(corners("4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n", ".OFF"), two);
  EXPECT_EQ(corners("ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\n"
                    "property float z\r\nproperty uchar red\r\nelement face 1\r\nproperty uchar flag\r\n"
                    "property list uchar uint vertex_index\r\nelement edge 1\r\nproperty int vertex1\r\nend_header\r\n"
                    "0 0 0 9\r\n1 0 0 9\r\n1 1 0 9\r\n0 1 0 9\r\n7 4 0 1 2 3\r\n5\r\n",
                    ".ply"),
            two);
}

TEST(FilesOfOtherPrograms, AreFilledAsOtherSurfacesAre) {
  SKIP_WITHOUT_GMSH();
  for (const auto& file : foreign_files({".ply", ".off"})) {
    Scene scene;
    scene.mesh.file = file;
    scene.mesh.target_size_m = 0.01;
    EXPECT_NEAR(make_mesh(scene).quality.volume_m3, 1 / 16384.0, 0.02 / 16384.0) << file;
  }
}

// A liver of 21 cm whose file is in decimetres, or in any unit but metres, is asked about.
TEST(FilesOfOtherPrograms, InAnotherUnitAreAskedAbout) {
  for (const double scale_to_m : {0.001, 0.01, 0.1, 1.0, 10.0, 100.0}) {
    const double size_m = 0.0625 * scale_to_m;
    EXPECT_EQ(contains(joined(import_file(any_body(), scale_to_m).warnings), "scale_to_m"), size_m < 1e-3 || size_m > 1)
        << size_m;
  }
}

}  // namespace
}  // namespace phynness::test
