// Claim: a region holds the cells whose centroids its selection contains, or those of a group of the mesh file; where
// regions overlap the highest order counts. Regions that are empty, the whole body or in conflict are refused with file
// and line. Cells keep their region when a mesh is refined, split or repaired.
#include <cmath>
#include <numbers>
#include <numeric>

#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

using Regions = std::vector<std::uint8_t>;

/// Its regions begin at lines 4, 9, ...
Scene scene_with(const std::vector<std::string>& regions, const std::string& mesh = "mesh.shape = \"block\"") {
  std::string text = mesh + "\nmaterial = { law = \"linear\", shear_modulus_Pa = 1, bulk_modulus_Pa = 1 }\n\n";
  int number = 0;
  for (const auto& cells : regions)
    text += "[[region]]\nname = \"r" + std::to_string(++number) + "\"\ncells = " + cells + "\nshear_modulus_Pa = 8\n\n";
  return parse_scene(text +
                         "[solver]\nelement = \"P1\"\n[nodes]\nfixed = { box = { min_fraction = [0, 0, 0], "
                         "max_fraction = [1, 1, 0] } }\n[probe]\nmax_displacement_m = 0.1\n",
                     "scene.toml", ".");
}

Eigen::RowVector3d middle(const Mesh& mesh, Eigen::Index c) {
  return mesh.nodes(mesh.cells.row(c), Eigen::all).colwise().mean();
}

/// 1 for the cells in whose middle the condition holds.
template <class Condition>
Regions where(const Mesh& mesh, const Condition& condition) {
  Regions regions;
  for (Eigen::Index c = 0; c < mesh.n_cells(); ++c) regions.push_back(condition(middle(mesh, c)) ? 1 : 0);
  return regions;
}

TEST(Regions, AreTheCellsWhoseMiddleIsInThePlace) {
  const Mesh mesh = grid();
  const auto regions = [&](const std::string& cells) { return cell_regions(scene_with({cells}), mesh); };
  const Eigen::RowVector3d c(1, 1, 2);
  EXPECT_EQ(regions("{ box = { min_m = [0, 0, 1], max_m = [2, 2, 2] } }"),
            where(mesh, [](const auto& x) { return x(2) >= 1; }));
  const Regions sphere = where(mesh, [&](const auto& x) { return (x - c).norm() <= 0.9; });
  EXPECT_GT(std::accumulate(sphere.begin(), sphere.end(), 0), 5);
  EXPECT_EQ(regions("{ sphere = { center_fraction = [0.5, 0.5, 1], radius_m = 0.9 } }"), sphere);
  EXPECT_EQ(regions("{ ellipsoid = { center_m = [1, 1, 2], radii_m = [0.9, 0.9, 0.9] } }"), sphere);
  EXPECT_EQ(regions("{ ellipsoid = { center_m = [1, 1, 2], radii_m = [1.5, 0.8, 0.6] } }"),
            where(mesh, [&](auto x) { return (x - c).cwiseQuotient(Eigen::RowVector3d(1.5, 0.8, 0.6)).norm() <= 1; }));
  EXPECT_EQ(regions("{ difference = [\"all\", { half_space = { point_m = [0, 0, 1], normal = [0, 0, 1] } }] }"),
            where(mesh, [](const auto& x) { return x(2) > 1; }));
  EXPECT_EQ(regions("{ near = { to = { nodes = [26] }, distance_m = 0.95 } }"),
            where(mesh, [](const auto& x) { return (x - Eigen::RowVector3d(2, 2, 2)).norm() <= 0.95; }));
}

TEST(Regions, OverlapWithAnOrderOnly) {
  const Mesh mesh = grid();
  const std::string low = "{ box = { min_m = [0, 0, 0], max_m = [2, 2, 1.3] } }",
                    high = "{ box = { min_m = [0, 0, 1.2], max_m = [2, 2, 2] } }";
  const auto expected = [&](int shared) {
    Regions regions;
    for (Eigen::Index c = 0; c < mesh.n_cells(); ++c) {
      const double z = middle(mesh, c)(2);
      regions.push_back(static_cast<std::uint8_t>(z < 1.2 ? 1 : z <= 1.3 ? shared : 2));
    }
    return regions;
  };
  EXPECT_EQ(cell_regions(scene_with({low, high + "\norder = 1"}), mesh), expected(2));
  EXPECT_EQ(cell_regions(scene_with({low + "\norder = 1", high}), mesh), expected(1));
  const auto message = error_of([&] { cell_regions(scene_with({low, high}), mesh); });
  EXPECT_TRUE(contains(message, "scene.toml:9: region 'r2' overlaps region 'r1'")) << message;
  EXPECT_TRUE(contains(message, "8 cells") && contains(message, "order = 1")) << message;
}

TEST(Regions, ThatAreEmptyOrAllAreRefused) {
  const Mesh mesh = grid();
  const auto refused = [&](const std::vector<std::string>& cells, const std::vector<std::string>& said) {
    const auto message = error_of([&] { cell_regions(scene_with(cells), mesh); });
    for (const auto& part : said) EXPECT_TRUE(contains(message, part)) << part << " is not in " << message;
  };
  refused({"{ sphere = { center_m = [5, 1, 1], radius_m = 0.5 } }"},
          {"scene.toml:6: ", "cells of region 'r1' selects no cell", "nearest cell", "smaller cells"});
  refused({"\"all\""}, {"scene.toml:4: region 'r1' is the whole body", "48 of 48", "[material]"});
  refused({"{ box = { min_m = [0, 0, 1], max_m = [2, 2, 2] } }\norder = 1",
           "{ box = { min_m = [0, 0, 1.5], max_m = [2, 2, 2] } }"},
          {"scene.toml:10: region 'r2' has no cell", "0 of 48", "lower their order"});
  refused({"{ group = \"lobe\" }"}, {"scene.toml:6: ", "no physical group of cells", "lobe", "box"});
}

TEST(Regions, SayWhichShareOfTheirVolumeIsOff) {
  // x < t = 0.4 of cubes of 6 cells, of which 2 have three corners at x = 0 and are inside; t^3, 3 t^2 - 2 t^3 and
  // 1 - (1 - t)^3 are the shares of the cells before t. With 64 points in a cell these are good to a few per cent.
  const double t = 0.4, off = 2.0 / 6 * (t * t * t + (3 * t * t - 2 * t * t * t) + (1 - t) * (1 - t) * (1 - t)) / t;
  const auto figures = region_figures(scene_with({"{ box = { min_m = [0, 0, 0], max_m = [0.4, 2, 2] } }"}), grid());
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_EQ(figures[1].name, "region r1");
  EXPECT_EQ(figures[1].cells, 8);
  EXPECT_NEAR(figures[1].volume_m3, 8.0 / 6, 1e-12);
  EXPECT_NEAR(figures[0].volume_m3 + figures[1].volume_m3, 8, 1e-12);
  EXPECT_NEAR(figures[1].off, off, 0.05);
  EXPECT_NE(figures[1].str().find("smaller cells"), std::string::npos) << figures[1].str();
  EXPECT_EQ(figures[1].shear_modulus_Pa, 8);
  const auto exact = region_figures(scene_with({"{ box = { min_m = [0, 0, 1], max_m = [2, 2, 2] } }"}), grid());
  EXPECT_EQ(exact[1].off, 0);
  EXPECT_EQ(exact[1].str().find("smaller cells"), std::string::npos) << exact[1].str();
}

TEST(Regions, StayWithTheirCellsWhereAMeshIsRefined) {
  Mesh mesh = grid();
  mesh.cell_groups["first"] = {0, 3};
  const Scene scene = scene_with({"{ group = \"first\" }"});
  mesh.regions = cell_regions(scene, mesh);
  const Mesh fine = refined(mesh);
  ASSERT_EQ(fine.regions.size(), static_cast<std::size_t>(fine.n_cells()));
  for (Eigen::Index c = 0; c < fine.n_cells(); ++c) EXPECT_EQ(fine.regions[c], mesh.regions[c / 8]) << c;
  EXPECT_EQ(fine.cell_groups.at("first").size(), 16u);
  Mesh unknown = fine;
  unknown.regions.clear();
  EXPECT_EQ(cell_regions(scene, unknown), fine.regions);
}

TEST(Regions, OfGroupsOfAFileComeThroughRepairs) {
  // The second cell is written twice, once for each of its groups, and the wrong way round.
  const std::string cells = "1 4 2 7 1 1 2 3 4\n2 4 2 8 1 2 3 5 4\n3 4 2 9 1 2 3 5 4\n";
  const auto msh = import_bytes(msh_2(cells, 3), ".msh").mesh;
  ASSERT_EQ(msh.n_cells(), 2);
  EXPECT_EQ(msh.cell_groups.at("7"), NodeList({0}));
  EXPECT_EQ(msh.cell_groups.at("8"), NodeList({1}));
  EXPECT_EQ(msh.cell_groups.at("9"), NodeList({1}));
  const std::string deck =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n9,0.5,0.5,2\n"
      "*ELEMENT,TYPE=C3D8,ELSET=CUBE\n1,1,2,3,4,5,6,7,8\n*ELEMENT,TYPE=C3D5,ELSET=ROOF\n2,5,6,7,8,9\n";
  const auto inp = import_bytes(deck, ".inp");
  ASSERT_TRUE(inp.mesh.cell_groups.contains("ROOF"));
  EXPECT_EQ(inp.mesh.cell_groups.at("ROOF").size(), 2u);
  ASSERT_TRUE(inp.mesh.cell_groups.contains("CUBE"));
  for (const auto c : inp.mesh.cell_groups.at("CUBE")) EXPECT_LT(middle(inp.mesh, c)(2), 1);
}

// Cells of a ball end at its surface: those of the group are all that have their middle in it, and their volume is that
// of the ball, to the rounding of sums.
TEST(Regions, OfBallsEndAtTheirSurface) {
  SKIP_WITHOUT_GMSH();
  const std::string ball = "{ sphere = { center_m = [0.05, 0.04, 0.025], radius_m = 0.012 } }";
  const double volume = 4 * std::numbers::pi / 3 * std::pow(0.012, 3);
  for (const std::string mesh :
       {"mesh = { shape = \"block\", target_size_m = 0.018 }",
        "mesh = { shape = \"cylinder\", radius_m = 0.1, length_m = 0.1, target_size_m = 0.03 }"}) {
    const MeshResult made = make_mesh(scene_with({ball}, mesh));
    const auto figures = region_figures(scene_with({ball}, mesh), made.mesh);
    EXPECT_NEAR(figures[1].volume_m3, volume, 1e-9 * volume) << joined(made.notes);
    EXPECT_LT(figures[1].off, 0.02) << mesh;  // 64 points in a cell; by the middles of cells 0.3
    EXPECT_GT(made.quality.min_quality, 0.1) << mesh;
    EXPECT_TRUE(contains(joined(made.notes), "region r1: ")) << joined(made.notes);
  }
}

TEST(Regions, OfBallsThatCrossTheSurfaceOrEachOtherAreAssignedByCells) {
  SKIP_WITHOUT_GMSH();
  const auto is_whole = [](const std::vector<std::string>& balls) {
    const Scene scene = scene_with(balls, "mesh = { shape = \"block\", target_size_m = 0.018 }");
    const MeshResult made = make_mesh(scene);
    std::vector<bool> whole;
    for (const auto& region : region_figures(scene, made.mesh)) {
      whole.push_back(region.off < 0.12);
      const bool says_why = contains(joined(made.notes), "do not end at the surface of " + region.name.substr(0, 6) +
                                                             " '" + region.name.substr(region.name.size() - 2) + "'");
      EXPECT_EQ(says_why, !whole.back()) << joined(made.notes);
    }
    return std::vector<bool>(whole.begin() + 1, whole.end());
  };
  const std::string ball = "{ sphere = { center_m = [0.04, 0.04, 0.025], radius_m = 0.012 } }";
  EXPECT_EQ(is_whole({"{ sphere = { center_m = [0.05, 0.04, 0.045], radius_m = 0.015 } }"}), std::vector{false});
  EXPECT_EQ(is_whole({ball, "{ sphere = { center_m = [0.06, 0.04, 0.025], radius_m = 0.012 } }\norder = 1"}),
            (std::vector{true, false}));
  EXPECT_EQ(is_whole({ball, "{ ellipsoid = { center_m = [0.075, 0.05, 0.025], radii_m = [0.012, 0.03, 0.012] } }"}),
            (std::vector{true, true}));
}

TEST(Regions, StayInAFileOfGmsh) {
  Mesh mesh = grid();
  for (Eigen::Index c = 0; c < mesh.n_cells(); ++c) mesh.regions.push_back(c % 5 == 3 ? 2 : c % 7 == 1);
  const TemporaryFile file("", ".msh");
  write_msh(mesh, nullptr, file.path);
  Mesh read = import_file(file.path).mesh;
  EXPECT_EQ(mesh_hash(read), mesh_hash(mesh));
  const Scene scene =
      scene_with({"{ group = \"" + region_group(1) + "\" }", "{ group = \"" + region_group(2) + "\" }"});
  EXPECT_EQ(cell_regions(scene, read), mesh.regions);
}

TEST(Regions, OfAWrittenMeshAreThoseOfItsScene) {
  const auto of = [](const std::string& z) {
    return scene_with({"{ box = { min_m = [0, 0, " + z + "], max_m = [2, 2, 2] } }"});
  };
  Mesh mesh = grid();
  mesh.regions = cell_regions(of("1"), mesh);
  const TemporaryFile file("", ".msh");
  write_msh(mesh, nullptr, file.path);
  const auto taken = [&](const Scene& scene) {
    Mesh read = import_file(file.path).mesh;
    take_written_regions(scene, read, "a.msh");
    return read.regions;
  };
  EXPECT_EQ(taken(of("1")), mesh.regions);
  EXPECT_TRUE(contains(error_of([&] { taken(of("1.6")); }), "region 'r1' is elsewhere in it"));
  mesh.regions.clear();
  write_msh(mesh, nullptr, file.path);
  EXPECT_TRUE(contains(error_of([&] { taken(of("1")); }), "has no group of cells phynness_region_1 for region 'r1'"));
}

}  // namespace
}  // namespace phynness::test
