#include "firmware/run/slot_watch.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rom/file/keys.hpp"
#include "rom/file/signature.hpp"
#include "rom/file/whole_file.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/support/temporary_folder.hpp"

/// What becomes of a file in the slot, look by look, without a thread.
namespace spindle_twin::firmware {
namespace run_slot_watch_test {

namespace fs = std::filesystem;

int times_in(const std::string& text, const std::string& what) {
  int found = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; ++at) ++found;
  return found;
}

/// A spindle at a machine that is as its network says, and its slot; trial and watch last half a minute each.
class Slot {
 public:
  explicit Slot(const std::vector<std::string>& sensors = {"inner", "middle", "outer"}) {
    fs::create_directory(folder_.file("slot"));
    rom::write_network(tests::small_network(), folder_.file("x.rom"));
    std::string text = "network = { file = \"x.rom\", trusted_keys = [\"" + rom::to_hex(rom::public_key(key_)) +
                       "\"] }\n[serve]\nport = 1502\n[device]\nport = 1503\n";
    for (const std::string& place : sensors) {
      text += "[[sensor]]\nkey_point = \"sleeve_" + place + "\"\nregister = " + std::to_string(place.front()) + "\n";
    }
    text +=
        "[signals]\nspeed = { source = \"constant\", value = 6000.0 }\nload = { source = \"constant\", value = 1.0 }\n"
        "coolant = { source = \"constant\", value = 27.0 }\nambient = { source = \"constant\", value = 27.0 }\n"
        "[exchange]\nslot = \"slot\"\ntrial_min = 0.5\nwatch_min = 0.5\nmargin_K = 0.5\n";
    text += "[start]\ntemperature_degC = 27.0\n";
    ConfiguredSpindle configured;
    configured.config = parse_config(text, folder_.file("twin.toml"));
    spindle = prepare(std::move(configured));
    exchange.emplace(spindle->cycle, spindle->config.exchange.plan);
    watch.emplace(*spindle, *exchange, [this] { ++kept_now; });
  }

  std::string path(const std::string& name) const { return folder_.file("slot/" + name); }
  bool has(const std::string& name) const { return fs::exists(path(name)); }
  /// Signed; the bytes.
  std::vector<std::uint8_t> put(const std::string& name, const rom::Network& network, bool with_signature = true) {
    rom::write_network(network, path(name));
    if (with_signature) rom::sign_file(path(name), key_);
    return bytes(path(name));
  }
  static std::vector<std::uint8_t> bytes(const std::string& path) { return rom::read_whole_file(path, 1U << 24U); }

  ExchangeState step(int cycles = 1) {
    for (int i = 0; i < cycles; ++i) {
      last = exchange->step(machine_.frame(at_s(n_)), {}, at_s(n_), 0);
      machine_.advance(1.0);
      ++n_;
    }
    return last.exchange.state;
  }
  /// A cycle and a look a second, until `state` or so many seconds have passed.
  ExchangeState run_until(ExchangeState state, int seconds = 200) {
    for (int i = 0; i < seconds && step() != state; ++i) watch->look();
    watch->look();
    return last.exchange.state;
  }

 private:
  tests::TemporaryFolder folder_;
  rom::PrivateKey key_ = rom::make_private_key();
  rom::Network network_ = tests::small_network();
  Machine machine_{network_, 1.0};
  int n_ = 0;

 public:
  std::unique_ptr<PreparedSpindle> spindle;
  std::optional<NetworkExchange> exchange;
  int kept_now = 0;
  std::optional<SlotWatch> watch;
  Snapshot last;
};

TEST(SlotWatch, a_network_as_good_is_accepted_written_down_and_taken_out_of_the_slot_and_so_is_the_next) {
  const Logged log;
  Slot slot;
  slot.step(5);
  const auto first = slot.put("one.rom", tests::with_conductances(1.001));
  ASSERT_EQ(slot.run_until(ExchangeState::accepted), ExchangeState::accepted) << log.text();
  EXPECT_EQ(slot.bytes(accepted_path(*slot.spindle)), first);
  EXPECT_FALSE(fs::exists(previous_path(*slot.spindle))) << "the configured one stays where it is configured";
  EXPECT_FALSE(slot.has("one.rom"));
  EXPECT_EQ(slot.kept_now, 1);
  EXPECT_NE(log.text().find("its trial begins, 0.5 min\n"), std::string::npos) << log.text();
  EXPECT_NE(log.text().find("watched for 0.5 min\n"), std::string::npos);
  const std::uint32_t accepted = slot.last.network_id;

  const auto second = slot.put("two.rom", tests::with_conductances(0.999));
  slot.step();
  ASSERT_EQ(slot.run_until(ExchangeState::trial), ExchangeState::trial) << log.text();
  ASSERT_EQ(slot.run_until(ExchangeState::accepted), ExchangeState::accepted) << log.text();
  EXPECT_EQ(slot.bytes(accepted_path(*slot.spindle)), second);
  EXPECT_EQ(slot.bytes(previous_path(*slot.spindle)), first);
  EXPECT_NE(slot.last.network_id, accepted);
  EXPECT_EQ(slot.kept_now, 2);
}

TEST(SlotWatch, a_file_counts_once_two_looks_have_found_it_the_same) {
  const Logged log;
  Slot slot;
  slot.step(5);
  slot.put("new.rom", tests::with_conductances(1.001));
  slot.watch->look();
  EXPECT_EQ(slot.step(), ExchangeState::none);
  std::ofstream(slot.path("new.rom"), std::ios::app) << "x";  // it is still being copied
  slot.watch->look();
  EXPECT_EQ(slot.step(), ExchangeState::none);
  slot.put("new.rom", tests::with_conductances(1.001));
  slot.watch->look();
  EXPECT_EQ(slot.step(), ExchangeState::none);
  slot.watch->look();
  EXPECT_EQ(slot.step(), ExchangeState::trial) << log.text();
}

TEST(SlotWatch, before_there_is_a_prediction_nothing_is_tried) {
  Slot slot;
  slot.put("new.rom", tests::with_conductances(1.001));
  for (int looks = 0; looks < 4; ++looks) slot.watch->look();
  EXPECT_EQ(slot.step(), ExchangeState::none);
  EXPECT_TRUE(slot.has("new.rom"));
  slot.watch->look();
  EXPECT_EQ(slot.step(), ExchangeState::trial) << "it had been there all the time";
}

TEST(SlotWatch, what_nobody_trusted_signed_is_put_aside_and_said) {
  const Logged log;
  Slot slot;
  slot.step(5);
  slot.put("new.rom", tests::with_conductances(1.001), false);
  slot.watch->look();
  slot.watch->look();
  EXPECT_FALSE(slot.has("new.rom"));
  EXPECT_TRUE(slot.has("new.rom.refused"));
  EXPECT_EQ(slot.step(), ExchangeState::refused);
  EXPECT_NE(log.text().find("put aside under its name and \".refused\"\n"), std::string::npos) << log.text();
  slot.watch->look();
  slot.watch->look();
  EXPECT_TRUE(slot.has("new.rom.refused")) << "and is no new network";
}

TEST(SlotWatch, the_network_that_runs_is_taken_out_of_the_slot_without_a_trial) {
  const Logged log;
  Slot slot;
  slot.step(5);
  fs::copy_file(slot.path("../x.rom"), slot.path("same.rom"));
  slot.watch->look();
  slot.watch->look();
  EXPECT_FALSE(slot.has("same.rom"));
  EXPECT_FALSE(slot.has("same.rom.refused"));
  EXPECT_EQ(slot.step(), ExchangeState::none);
}

TEST(SlotWatch, without_a_sensor_nothing_can_judge_a_network_and_one_is_enough_whichever_it_is) {
  for (const std::vector<std::string>& sensors : {std::vector<std::string>{}, {"inner"}, {"outer"}}) {
    const Logged log;
    Slot slot(sensors);
    slot.step(5);
    slot.put("new.rom", tests::with_conductances(1.001));
    slot.watch->look();
    slot.watch->look();
    EXPECT_EQ(slot.step(), sensors.empty() ? ExchangeState::refused : ExchangeState::trial);
    EXPECT_EQ(slot.has("new.rom.refused"), sensors.empty());
    EXPECT_EQ(log.text().find("no sensor is configured") != std::string::npos, sensors.empty()) << log.text();
  }
}

TEST(SlotWatch, one_that_took_the_name_of_the_accepted_one_meanwhile_has_its_own_trial) {
  const Logged log;
  Slot slot;
  slot.step(5);
  const auto first = slot.put("new.rom", tests::with_conductances(1.001));
  ASSERT_EQ(slot.run_until(ExchangeState::keeping), ExchangeState::keeping) << log.text();
  slot.put("new.rom", tests::with_conductances(0.999));
  EXPECT_EQ(slot.step(), ExchangeState::accepted);
  slot.watch->look();
  EXPECT_EQ(slot.bytes(accepted_path(*slot.spindle)), first);
  EXPECT_TRUE(slot.has("new.rom"));
  EXPECT_EQ(slot.run_until(ExchangeState::trial), ExchangeState::trial);
}

TEST(SlotWatch, a_slot_that_is_gone_is_said_once_each_time_it_goes) {
  Slot slot;
  slot.step(5);
  const Logged log;
  const auto lines = [&] { return times_in(log.text(), "; tried again\n"); };
  for (int times = 1; times <= 2; ++times) {
    fs::remove(slot.path(""));
    for (int looks = 0; looks < 3; ++looks) slot.watch->look();
    EXPECT_EQ(lines(), times) << log.text();
    fs::create_directory(slot.path(""));
    slot.watch->look();
    EXPECT_EQ(lines(), times);
  }
  slot.put("new.rom", tests::with_conductances(1.001));
  EXPECT_EQ(slot.run_until(ExchangeState::trial), ExchangeState::trial);
}

TEST(SlotWatch, who_takes_the_file_away_or_replaces_it_ends_its_trial) {
  for (const bool replaced : {false, true}) {
    const Logged log;
    Slot slot;
    slot.step(5);
    slot.put("new.rom", tests::with_conductances(1.001));
    ASSERT_EQ(slot.run_until(ExchangeState::trial), ExchangeState::trial);
    fs::remove(slot.path("new.rom"));
    if (replaced) slot.put("new.rom", tests::with_conductances(0.999));
    slot.watch->look();
    EXPECT_EQ(slot.step(), ExchangeState::refused);
    slot.watch->look();
    EXPECT_EQ(slot.has("new.rom"), replaced) << "the other one has its own trial";
    EXPECT_FALSE(slot.has("new.rom.refused"));
    EXPECT_NE(log.text().find("given up, its file was taken out of the slot, or changed"), std::string::npos)
        << log.text();
    if (!replaced) continue;
    EXPECT_EQ(slot.run_until(ExchangeState::trial), ExchangeState::trial);
  }
}

TEST(SlotWatch, one_that_foretells_worse_is_put_aside_with_the_reason) {
  const Logged log;
  Slot slot;
  slot.step(5);
  slot.put("new.rom", tests::with_conductances(0.02));
  EXPECT_EQ(slot.run_until(ExchangeState::refused), ExchangeState::refused);
  EXPECT_TRUE(slot.has("new.rom.refused"));
  EXPECT_FALSE(fs::exists(accepted_path(*slot.spindle)));
  EXPECT_EQ(slot.kept_now, 0);
  EXPECT_NE(log.text().find("new.rom: refused, "), std::string::npos) << log.text();
  EXPECT_EQ(log.text().find("the old network is shown again"), std::string::npos) << "it was never shown";
}

/// A folder of the name that it would get keeps it where it is.
TEST(SlotWatch, one_that_cannot_be_put_aside_is_refused_once_and_looked_at_again_when_it_changes) {
  Slot slot;
  slot.step(5);
  fs::create_directory(slot.path("new.rom.refused"));
  std::ofstream(slot.path("new.rom.refused/occupied")) << "1";
  int refusals = 0;
  const Logged log;
  const auto refused = [&] { return times_in(log.text(), "and is left alone\n"); };
  for (const double factor : {1.001, 1.0015}) {
    slot.put("new.rom", tests::with_conductances(factor), false);
    for (int looks = 0; looks < 5; ++looks) slot.watch->look();
    EXPECT_EQ(refused(), ++refusals) << log.text();
    EXPECT_TRUE(slot.has("new.rom"));
  }
  slot.put("other.rom", tests::with_conductances(1.001));
  EXPECT_EQ(slot.run_until(ExchangeState::trial), ExchangeState::trial) << "it is in nobody's way";
}

TEST(SlotWatch, other_names_folders_and_links_are_no_new_network_and_those_that_look_like_one_are_named_once) {
  const Logged log;
  Slot slot;
  slot.step(5);
  const auto kept = slot.put("accepted-0123456789abcdef.rom", tests::with_conductances(1.001));
  slot.put("previous-0123456789abcdef.rom", tests::with_conductances(1.001));
  slot.put("new.rom.part", tests::with_conductances(1.001));
  fs::create_directory(slot.path("folder.rom"));
  fs::create_symlink(slot.path("new.rom.part"), slot.path("link.rom"));
  slot.put("LOUD.ROM", tests::with_conductances(1.001));
  for (int looks = 0; looks < 3; ++looks) slot.watch->look();
  for (const std::string name : {"folder.rom", "link.rom", "LOUD.ROM"}) {
    EXPECT_EQ(times_in(log.text(), slot.path(name) + ": left alone"), 1) << name;
  }
  EXPECT_EQ(times_in(log.text(), "left alone"), 3) << log.text();
  EXPECT_EQ(slot.step(), ExchangeState::none);
  EXPECT_EQ(slot.bytes(slot.path("accepted-0123456789abcdef.rom")), kept);
}

TEST(SlotWatch, of_several_the_first_by_name_is_tried_and_the_next_waits) {
  Slot slot;
  slot.step(5);
  slot.put("b.rom", tests::with_conductances(1.001));
  slot.put("a.rom", tests::with_conductances(1.002));
  ASSERT_EQ(slot.run_until(ExchangeState::trial), ExchangeState::trial);
  fs::remove(slot.path("b.rom"));
  slot.watch->look();
  EXPECT_EQ(slot.step(), ExchangeState::trial) << "that one was not under trial";
  fs::remove(slot.path("a.rom"));
  slot.watch->look();
  EXPECT_EQ(slot.step(), ExchangeState::refused);
}

}  // namespace run_slot_watch_test
}  // namespace spindle_twin::firmware
