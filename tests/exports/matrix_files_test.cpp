#include "host_tools/network_files/matrix_files.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCore>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <unsupported/Eigen/SparseExtra>

#include "rom/read/input_error.hpp"
#include "tests/rom/synthetic_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::host_tools::tests {
namespace matrix_files_test {

namespace fs = std::filesystem;

Eigen::MatrixXd read(const fs::path& path) {
  Eigen::SparseMatrix<double> matrix;
  EXPECT_TRUE(Eigen::loadMarket(matrix, path.string())) << path;
  return matrix;
}

TEST(MatrixFiles, every_matrix_comes_back_bit_for_bit) {
  const rom::Network network = rom::tests::make_synthetic_network({}, 11);
  const spindle_twin::tests::TemporaryFolder temporary;
  const fs::path folder = temporary.path() / "matrices";
  write_matrix_files(network, folder);
  EXPECT_EQ(read(folder / "capacity.mtx"), network.capacity_J_per_K);
  EXPECT_EQ(read(folder / "conduction.mtx"), network.conduction_W_per_K);
  EXPECT_EQ(read(folder / "source_distribution.mtx"), network.source_distribution);
  const nlohmann::json names = nlohmann::json::parse(std::ifstream(folder / "network.json"));
  ASSERT_EQ(names["conductances"].size(), network.factors_m.size());
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    EXPECT_EQ(read(folder / names["conductances"][j]["file"]), network.factors_m[j]);
    EXPECT_EQ(names["conductances"][j]["name"], network.boundaries.conductances[j].name);
  }
  const Eigen::MatrixXd key_points = read(folder / "key_points.mtx");
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    EXPECT_EQ(key_points.row(static_cast<Eigen::Index>(k)).transpose(), network.key_points[k].row);
  }
  EXPECT_EQ(read(folder / "deformations.mtx").row(0).transpose(), network.deformations[0].row_m_per_K);
  EXPECT_TRUE(fs::exists(folder / "README.md"));

  EXPECT_THROW(write_matrix_files(network, folder), rom::InputError) << "the folder is not empty";
  EXPECT_THROW(write_matrix_files(network, "/nowhere/at/all"), rom::InputError);
}

}  // namespace matrix_files_test
}  // namespace spindle_twin::host_tools::tests
