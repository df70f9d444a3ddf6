#include "firmware/show/page_files.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "firmware/cycle/states.hpp"

namespace spindle_twin::firmware {
namespace show_page_files_test {

TEST(PageFiles, each_page_names_the_files_that_stand_beside_it) {
  for (const auto& [path, name] :
       {std::pair<std::string, std::string>{"/", "live_page"}, {"/commissioning", "commissioning"}}) {
    const std::string html = page_file(path)->body;
    EXPECT_NE(html.find("href=\"" + name + ".css\""), std::string::npos);
    EXPECT_NE(html.find("src=\"" + name + ".js\""), std::string::npos);
    EXPECT_EQ(page_file("/" + name + ".css")->type, "text/css; charset=utf-8");
    EXPECT_EQ(page_file("/" + name + ".js")->type, "text/javascript; charset=utf-8");
    EXPECT_FALSE(page_file("/" + name + ".html"));
  }
}

TEST(PageFiles, nothing_in_them_makes_html_of_data_or_needs_a_policy_that_is_wider) {
  for (const char* path : {"/live_page.js", "/commissioning.js"}) {
    const std::string script = page_file(path)->body;
    // The report reads outerHTML, of elements that were made one by one.
    for (const char* word : {"innerHTML", "outerHTML =", "insertAdjacentHTML", "document.write", "eval("}) {
      EXPECT_EQ(script.find(word), std::string::npos) << path << ": " << word;
    }
  }
  for (const char* path : {"/", "/commissioning"}) {
    const std::string html = page_file(path)->body;
    for (const char* word : {"<style", " style=", "onclick", "https:"}) {
      EXPECT_EQ(html.find(word), std::string::npos) << path << ": " << word;
    }
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
