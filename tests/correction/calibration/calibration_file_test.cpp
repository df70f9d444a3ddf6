#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "correction/calibration/calibration.hpp"
#include "rom/read/input_error.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::correction::test {
namespace calibration_file_test {

Calibration some_calibration(const rom::Network& network) {
  const ParameterModel parameters(network, {});
  Calibration calibration;
  calibration.spindle = network.spindle;
  calibration.network_sha256 = std::string(64, 'a');
  calibration.made_unix_s = 1.7e9;
  calibration.tested_s = 7200.0;
  calibration.logs = {"monday.csv", "tuesday, cold.csv"};
  constexpr Eigen::Index count = 3;
  calibration.mean = Eigen::VectorXd::LinSpaced(count, -0.3, 0.4);
  calibration.prior_mean = Eigen::VectorXd::Constant(count, 0.1);
  calibration.prior_deviation = Eigen::VectorXd::Constant(count, 0.5);
  calibration.nominal.resize(count);
  calibration.root = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    calibration.names.push_back(parameters.list()[static_cast<std::size_t>(i)].name);
    calibration.nominal[i] = parameters.list()[static_cast<std::size_t>(i)].nominal;
    for (Eigen::Index k = 0; k <= i; ++k) calibration.root(i, k) = 0.1 + 0.01 * static_cast<double>(i + 2 * k);
  }
  calibration.promised_m = 0.9e-6;
  return calibration;
}

std::string refusal(const std::function<void()>& what) {
  try {
    what();
    return "taken";
  } catch (const rom::InputError& error) {
    return error.what();
  }
}

TEST(CalibrationFile, comes_back_as_it_was) {
  const tests::TemporaryFolder folder;
  const Calibration written = some_calibration(plates());
  write_calibration(written, folder.file("a.calibration"));
  const Calibration read = read_calibration(folder.file("a.calibration"));
  EXPECT_EQ(read.spindle, written.spindle);
  EXPECT_EQ(read.network_sha256, written.network_sha256);
  EXPECT_EQ(read.logs, written.logs);
  EXPECT_EQ(read.names, written.names);
  EXPECT_EQ(read.mean, written.mean);
  EXPECT_EQ(read.root, written.root);
  EXPECT_EQ(read.prior_deviation, written.prior_deviation);
  EXPECT_EQ(read.nominal, written.nominal);
  EXPECT_EQ(read.made_unix_s, written.made_unix_s);
  EXPECT_EQ(read.tested_s, written.tested_s);
  EXPECT_EQ(read.promised_m, written.promised_m);
  EXPECT_TRUE(read.accepted);
}

TEST(CalibrationFile, no_damaged_bit_and_no_cut_file_is_taken) {
  const std::vector<std::uint8_t> bytes = encode_calibration(some_calibration(plates()));
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += 3) {
    std::vector<std::uint8_t> damaged = bytes;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    EXPECT_NE(refusal([&] { decode_calibration(damaged, "x"); }), "taken") << "bit " << bit;
  }
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    const std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(refusal([&] { decode_calibration(cut, "x"); }), "x: no calibration of this version, or damaged");
  }
}

TEST(CalibrationFile, a_signature_is_of_its_signer_and_of_every_byte_before_it) {
  const Calibration written = some_calibration(plates());
  const rom::PrivateKey key = rom::make_private_key();
  const std::vector<std::uint8_t> bytes = encode_calibration(written, &key);
  const CalibrationFile read = decode_calibration(bytes, "x");
  EXPECT_EQ(read.signed_by, rom::public_key(key));
  EXPECT_EQ(encode_calibration(read.calibration), encode_calibration(written));
  EXPECT_FALSE(decode_calibration(encode_calibration(written), "x").signed_by.has_value());
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += 5) {
    std::vector<std::uint8_t> damaged = bytes;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    EXPECT_NE(refusal([&] { decode_calibration(damaged, "x"); }), "taken") << "bit " << bit;
  }
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    const std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_NE(refusal([&] { decode_calibration(cut, "x"); }), "taken") << size << " bytes";
  }
}

TEST(CalibrationFile, another_files_signature_does_not_fit) {
  const rom::PrivateKey key = rom::make_private_key();
  const Calibration one = some_calibration(plates());
  Calibration other = one;
  other.mean[0] += 0.1;
  const std::vector<std::uint8_t> theirs = encode_calibration(other, &key);
  std::vector<std::uint8_t> mixed = encode_calibration(one, &key);
  ASSERT_EQ(mixed.size(), theirs.size());
  std::copy(theirs.end() - 104, theirs.end(), mixed.end() - 104);
  EXPECT_EQ(refusal([&] { decode_calibration(mixed, "x"); }), "x: signature: does not fit the file, or is damaged");
}

TEST(CalibrationFile, numbers_that_are_none_are_refused) {
  Calibration calibration = some_calibration(plates());
  calibration.mean[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal([&] { decode_calibration(encode_calibration(calibration), "x"); }), "x: malformed");
  calibration = some_calibration(plates());
  calibration.root(1, 1) = 0.0;
  EXPECT_EQ(refusal([&] { decode_calibration(encode_calibration(calibration), "x"); }),
            "x: root: its diagonal must be above 0");
}

TEST(CalibrationFile, each_list_and_number_of_it_is_looked_at) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const std::function<void(Calibration&)>& change) {
    Calibration calibration = some_calibration(plates());
    change(calibration);
    return refusal([&] { decode_calibration(encode_calibration(calibration), "x"); }) == "x: malformed";
  };
  EXPECT_FALSE(refused([](Calibration&) {}));
  for (const auto member : {&Calibration::prior_mean, &Calibration::prior_deviation, &Calibration::nominal}) {
    for (const Eigen::Index size : {2, 4}) {
      EXPECT_TRUE(refused([&](Calibration& calibration) { calibration.*member = Eigen::VectorXd::Ones(size); }));
    }
    EXPECT_TRUE(refused([&](Calibration& calibration) { (calibration.*member)[2] = none; }));
  }
  EXPECT_TRUE(refused([](Calibration& calibration) { calibration.mean.conservativeResize(2); }));
  EXPECT_TRUE(refused([](Calibration& calibration) { calibration.names.push_back("one more"); }));
  EXPECT_TRUE(refused([](Calibration& calibration) { calibration.names.pop_back(); }));
  EXPECT_TRUE(refused([&](Calibration& calibration) { calibration.root(2, 0) = none; }));
  for (const auto member : {&Calibration::made_unix_s, &Calibration::tested_s, &Calibration::promised_m}) {
    EXPECT_TRUE(refused([&](Calibration& calibration) { calibration.*member = none; }));
  }
  EXPECT_FALSE(refused([](Calibration& calibration) { calibration.nominal.resize(0); })) << "a file of before";
}

TEST(CalibrationFile, has_one_parameter_at_the_least_and_512_at_the_most) {
  for (const Eigen::Index count : {0, 1, 512, 513}) {
    Calibration calibration;
    calibration.spindle = "many";
    for (Eigen::Index i = 0; i < count; ++i) calibration.names.push_back("heat " + std::to_string(i));
    calibration.mean = calibration.prior_mean = calibration.prior_deviation = Eigen::VectorXd::Ones(count);
    calibration.root = 0.5 * Eigen::MatrixXd::Identity(count, count);
    const std::vector<std::uint8_t> bytes = encode_calibration(calibration);
    const bool fits = count >= 1 && count <= 512;
    EXPECT_EQ(refusal([&] { decode_calibration(bytes, "x"); }), fits ? "taken" : "x: malformed") << count;
    if (fits) {
      EXPECT_EQ(decode_calibration(bytes, "x").calibration.root, calibration.root);
    }
  }
}

TEST(CalibrationFile, of_more_than_four_mebibytes_is_not_even_read) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("large.calibration");
  std::ofstream(path, std::ios::binary) << std::string((1U << 22U) + 1U, 'x');
  EXPECT_EQ(refusal([&] { read_calibration(path); }), path + ": 4194305 bytes; at most 4194304 are allowed");
}

TEST(CalibrationFile, of_another_spindle_or_of_parameters_it_does_not_have_is_refused_by_name) {
  const rom::Network network = plates();
  Calibration calibration = some_calibration(network);
  check_fits(calibration, network, {}, "x");
  calibration.spindle = "other";
  EXPECT_EQ(refusal([&] { check_fits(calibration, network, {}, "x"); }),
            "x: spindle: \"other\" was calibrated, and the network is of \"" + network.spindle + "\"");
  calibration = some_calibration(network);
  calibration.names[2] = "heat sauna";
  EXPECT_NE(refusal([&] { check_fits(calibration, network, {}, "x"); }).find("\"heat sauna\""), std::string::npos);
  EstimatorPriors without_heats;
  without_heats.heat = 0.0;
  EXPECT_NE(refusal([&] { check_fits(some_calibration(network), network, without_heats, "x"); }), "taken");
}

TEST(CalibratedPrior, keeps_watts_and_conductances_where_the_network_has_other_nominal_values) {
  const rom::Network network = plates();
  Calibration calibration = some_calibration(network);
  calibration.mean *= 0.5;
  rom::Network renewed = network;
  for (rom::HeatSource& source : renewed.boundaries.sources) source.nominal_W *= 1.25;
  for (rom::Conductance& conductance : renewed.boundaries.conductances) conductance.nominal_W_per_m2K *= 0.8;
  EstimatorPriors priors;
  const auto moved = [&] {
    priors.calibrated = prior_of(calibration, {});
    const Eigen::VectorXd now = ParameterModel(renewed, priors).mean().head(3);
    return Eigen::VectorXd(now - calibration.mean);
  };
  const Eigen::VectorXd shift = moved();
  const ParameterModel model(renewed, priors);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const bool heat = model.list()[static_cast<std::size_t>(i)].kind == ParameterKind::heat;
    EXPECT_NEAR(shift[i], heat ? -std::log(1.25) : std::log(1.25), 1e-12) << i;
  }
  calibration.nominal.resize(0);  // a file of before says nothing of them
  EXPECT_TRUE(moved().isZero(1e-12));
}

TEST(CalibratedPrior, takes_the_place_of_the_priors_with_drift_on_the_diagonal_and_leaves_the_others) {
  const rom::Network network = plates();
  const Calibration calibration = some_calibration(network);
  const DriftOptions drift{0.05, 0.10, 0.07};
  EstimatorPriors priors;
  const ParameterModel before(network, priors);
  priors.calibrated = prior_of(calibration, drift);
  const ParameterModel after(network, priors);
  ASSERT_EQ(after.count(), before.count());
  const Eigen::MatrixXd posterior = calibration.root * calibration.root.transpose();
  for (Eigen::Index i = 0; i < after.count(); ++i) {
    for (Eigen::Index k = 0; k < after.count(); ++k) {
      const bool calibrated = i < 3 && k < 3;
      double expected = calibrated ? posterior(i, k) : i < 3 || k < 3 ? 0.0 : before.covariance()(i, k);
      if (calibrated && i == k) {
        const ParameterKind kind = after.list()[static_cast<std::size_t>(i)].kind;
        const double drifted = kind == ParameterKind::heat      ? drift.heat
                               : kind == ParameterKind::contact ? drift.contact
                                                                : drift.film;
        expected += drifted * drifted;
      }
      EXPECT_DOUBLE_EQ(after.covariance()(i, k), expected) << i << ", " << k;
    }
    EXPECT_DOUBLE_EQ(after.mean()[i], i < 3 ? calibration.mean[i] : before.mean()[i]);
  }
  ASSERT_NE(after.calibrated(), nullptr);
  EXPECT_EQ(before.calibrated(), nullptr);
  priors.calibrated = prior_of(calibration, {0.05, 0.10, 0.08});
  EXPECT_NE(ParameterModel(network, priors).calibrated()->origin, after.calibrated()->origin);
}

}  // namespace calibration_file_test
}  // namespace spindle_twin::correction::test
