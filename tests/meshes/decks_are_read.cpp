// Claim: the nodes, solid elements of first order, triangles and sets of a deck of CalculiX or Abaqus are read, and
// its steps, materials and loads are skipped with a note. An empty coordinate is 0. A card that makes or moves nodes in
// an unsupported way is refused and never ignored.
#include "mesh_under_test.hpp"
#include "read/raw_mesh.hpp"

namespace phynness::test {
namespace {

const std::string deck_nodes =
    "*NODE, NSET=Nall\n1, 0., 0., 0.\n2, 1., 0.\n3, 0., 1.D0, 0.\n4, 0., 0., 1.\n5, 1., 1., 1.\n";
const std::string tissue_deck =
    "*Heading\nnothing, of interest\n** a comment\n" + deck_nodes +
    "*Element, type=C3D4, elset=Body\n1, 1, 2, 3, 4\n7, 2, 5, 3,\n 4\n"
    "*NSET, NSET=hilum\n1, 2,\n3\n*NSET, NSET=both\nHILUM, 5\n"
    "*NSET, NSET=odd, GENERATE\n1, 5, 2\n*ELSET, ELSET=far\n7\n"
    "*MATERIAL, NAME=tissue\n*ELASTIC\n1000., 0.4, 20.\n*STEP\n*STATIC\n0.1, 1.\n*BOUNDARY\nhilum, 1, 3\n"
    "*END STEP\n";

using Nodes = std::vector<std::int32_t>;

TEST(Decks, HoldNodesTetrahedraAndSets) {
  const Mesh mesh = import_bytes(tissue_deck, ".inp").mesh;
  EXPECT_EQ(mesh_hash(mesh), mesh_hash(import_bytes(msh_2(two_cells, 2), ".msh").mesh));
  EXPECT_EQ(mesh.groups.at("hilum"), (Nodes{0, 1, 2}));
  EXPECT_EQ(mesh.groups.at("both"), (Nodes{0, 1, 2, 4}));
  EXPECT_EQ(mesh.groups.at("odd"), (Nodes{0, 2, 4}));
  EXPECT_EQ(mesh.groups.at("Body"), (Nodes{0, 1, 2, 3, 4}));
  EXPECT_EQ(mesh.groups.at("far"), (Nodes{1, 2, 3, 4}));
  EXPECT_EQ(mesh.groups.at("Nall"), (Nodes{0, 1, 2, 3, 4}));
}

TEST(Decks, MayHaveContinuedCards) {
  const std::string continued = deck_nodes + "*ELEMENT,\n** a comment,\nTYPE=C3D4\n1, 1, 2, 3, 4\n7, 2, 5, 3, 4\n";
  EXPECT_EQ(mesh_hash(import_bytes(continued, ".inp").mesh), mesh_hash(import_bytes(tissue_deck, ".inp").mesh));
}

TEST(Decks, MayHoldTheTrianglesOfASurface) {
  const TemporaryFile file(deck_nodes + "*ELEMENT, TYPE=S3\n1, 1, 3, 2\n2, 1, 2, 4\n*ELEMENT, TYPE=T3D2\n3, 1, 2\n",
                           ".inp");
  EXPECT_EQ(meshes::read_mesh_file(file.path).triangles, (std::vector<meshes::Triangle>{{0, 2, 1}, {0, 1, 3}}));
}

TEST(Decks, HoldSetsOfSetsAndTheNodesOfElements) {
  const std::string deck = deck_nodes +
                           "*ELEMENT, TYPE=C3D4H\n1, 1, 2, 3, 4\n7, 2, 5, 3, 4\n*NSET, NSET=near, ELSET=later\n"
                           "*NSET, NSET=outer\nNEAR, , 5\n*ELSET, ELSET=later\n1\n*ELSET, ELSET=all\nlater, 7\n";
  const MeshResult result = import_bytes(deck, ".inp");
  EXPECT_EQ(result.mesh.groups.at("near"), (Nodes{0, 1, 2, 3}));
  EXPECT_EQ(result.mesh.groups.at("outer"), (Nodes{0, 1, 2, 3, 4}));
  EXPECT_EQ(result.mesh.groups.at("all"), (Nodes{0, 1, 2, 3, 4}));
  EXPECT_TRUE(result.notes.empty()) << joined(result.notes);
  EXPECT_TRUE(contains(joined(import_bytes(deck + "*NSET, NSET=none\n", ".inp").notes), "set none holds nothing"));
}

TEST(Decks, SayThatTheirMaterialsAreNotUsed) {
  EXPECT_TRUE(contains(joined(import_bytes(tissue_deck, ".inp").notes), "materials"));
}

TEST(Decks, TakeAnEmptyCoordinateForZero) {
  std::string empty = tissue_deck;
  for (std::size_t at = 0; (at = empty.find(" 0.,", at)) != std::string::npos;) empty.replace(at, 4, " ,");
  EXPECT_EQ(mesh_hash(import_bytes(empty, ".inp").mesh), mesh_hash(import_bytes(tissue_deck, ".inp").mesh));
}

TEST(Decks, OfTwoSetsOfOneNameKeepBoth) {
  const MeshResult result = import_bytes(tissue_deck + "*NSET, NSET=BODY\n5\n", ".inp");
  EXPECT_EQ(result.mesh.groups.at("BODY"), (Nodes{4}));
  EXPECT_EQ(result.mesh.groups.at("elements Body").size(), 5u);
  EXPECT_TRUE(contains(joined(result.notes), "'elements Body'"));
}

TEST(Decks, AreRefusedWithTheLineOfWhatIsNotRead) {
  const std::string cells = "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n";
  const std::pair<std::string, const char*> decks[] = {
      {deck_nodes + "*ELEMENT, TYPE=C3D10\n1, 1, 2, 3, 4, 5, 1, 2, 3, 4, 5\n",
       ":7: elements of a type that is not supported: C3D10"},
      {deck_nodes + "*ELEMENT\n1, 1, 2, 3, 4\n", "elements of a type"},
      {deck_nodes + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 9\n",
       ":8: element 1 uses a node that is not in the file above it: node 9"},
      {deck_nodes + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3\n*STEP\n", "too few nodes"},
      {deck_nodes + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3\n", "too few nodes"},
      {deck_nodes + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4, 5\n", "too many nodes"},
      {deck_nodes + cells + "1, 2, 5, 3, 4\n", "two elements have the same number"},
      {deck_nodes + cells + deck_nodes, "two nodes have the same number"},
      {"*INCLUDE, INPUT=mesh.inp\n", ":1: "},
      {"*NODE, INPUT=nodes.txt\n" + cells, "*NODE, INPUT"},
      {"*NODE, SYSTEM=C\n1, 0, 0, 0\n", "Cartesian"},
      {deck_nodes + cells + "*NGEN\n1, 5, 1\n", "*NGEN"},
      {deck_nodes + cells + "*INSTANCE, NAME=a, PART=b\n1., 0., 0.\n*END INSTANCE\n", "instance"},
      {deck_nodes + cells + "*NSET, NSET=a, GENERATE\n1, 999999999999, 1\n", "impossible range"},
      {deck_nodes + cells + "*NSET, NSET=a, GENERATE\n1, 5, 0\n", "impossible range"},
      {deck_nodes + cells + "*NSET, NSET=a\nb\n", "not in the file"},
      {deck_nodes + cells + "*NSET\n1\n", "no name"},
      {deck_nodes + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, x\n", "expected a number"},
      {"8 1 0 0 0\n1 0 0 0\n", ":1: not a deck of Abaqus or CalculiX"},
      {deck_nodes + "*NODE\n6\n" + cells, "three coordinates"},
      {deck_nodes, "neither tetrahedra"},
      {",\n\n*\n*,\n", "neither tetrahedra"}};
  for (const auto& [bytes, part] : decks) expect_names(import_error(bytes, ".inp"), {part});
  // Sets that name each other are no endless list.
  const std::string circle = deck_nodes + cells + "*NSET, NSET=a\nb, 1\n*NSET, NSET=b\na, 2\n";
  EXPECT_EQ(import_bytes(circle, ".inp").mesh.groups.at("a"), (Nodes{0, 1}));
}

}  // namespace
}  // namespace phynness::test
