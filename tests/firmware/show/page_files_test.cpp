#include "firmware/show/page_files.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "firmware/cycle/states.hpp"

namespace spindle_twin::firmware {
namespace show_page_files_test {

TEST(PageFiles, the_page_names_the_files_that_stand_beside_it) {
  const std::string html = page_file("/")->body;
  EXPECT_NE(html.find("href=\"live_page.css\""), std::string::npos);
  EXPECT_NE(html.find("src=\"live_page.js\""), std::string::npos);
  EXPECT_EQ(page_file("/live_page.css")->type, "text/css; charset=utf-8");
  EXPECT_EQ(page_file("/live_page.js")->type, "text/javascript; charset=utf-8");
  EXPECT_FALSE(page_file("/live_page.html"));
}

TEST(PageFiles, nothing_in_them_makes_html_of_data_or_needs_a_policy_that_is_wider) {
  const std::string script = page_file("/live_page.js")->body;
  for (const char* word : {"innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval("}) {
    EXPECT_EQ(script.find(word), std::string::npos) << word;
  }
  const std::string html = page_file("/")->body;
  for (const char* word : {"<style", " style=", "onclick", "https:"}) {
    EXPECT_EQ(html.find(word), std::string::npos) << word;
  }
}

TEST(PageFiles, every_code_and_bit_has_its_words) {
  const nlohmann::json words = nlohmann::json::parse(words_json());
  EXPECT_EQ(words.at("state").at(1).at("name"), "running");
  EXPECT_EQ(words.at("quality").size(), quality_codes.size());
  EXPECT_EQ(words.at("compensation_rung").size(), rung_codes.size());
  for (const auto& [name, codes] : words.items()) {
    for (const nlohmann::json& code : codes) EXPECT_FALSE(code.at("doc").get<std::string>().empty()) << name;
  }
}

}  // namespace show_page_files_test
}  // namespace spindle_twin::firmware
