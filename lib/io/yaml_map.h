#pragma once
#include <yaml-cpp/yaml.h>

#include <initializer_list>
#include <string>

#include "base/error.h"
#include "io/header_text.h"

namespace vol::io {

/// A YAML map that is read strictly: every key must be one of those named, once.
class YamlMap {
 public:
  YamlMap(const YAML::Node& node, const std::string& what, std::initializer_list<const char*> keys)
      : node_(node) {
    if (!node.IsMap()) fail(node, what + ": a map of keys is expected");
    std::string all;
    for (const char* key : keys) all += (all.empty() ? "" : ", ") + std::string(key);
    std::string seen = "\n";
    for (const auto& entry : node) {
      const auto key = entry.first.as<std::string>();
      bool known = false;
      for (const char* k : keys) known = known || key == k;
      if (!known) fail(entry.first, what + ": unknown key " + in_quotes(key) + "; known are " + all);
      if (seen.find("\n" + key + "\n") != std::string::npos)
        fail(entry.first, what + ": key '" + key + "' twice");
      seen += key + "\n";
    }
  }

  [[nodiscard]] bool has(const char* key) const { return node_[key].IsDefined(); }
  [[nodiscard]] YAML::Node operator[](const char* key) const { return node_[key]; }

  /// A value of a type, or `fallback` where the key is missing.
  template <class T>
  [[nodiscard]] T get(const char* key, const T& fallback) const {
    return has(key) ? as<T>(node_[key], key) : fallback;
  }
  template <class T>
  [[nodiscard]] static T as(const YAML::Node& node, const std::string& what) {
    try {
      return node.as<T>();
    } catch (const YAML::Exception&) {
      fail(node, what + ": a " + (std::is_same_v<T, std::string> ? "word" : "number") + " is expected");
    }
  }
  /// A word that messages can repeat in their one line: no line end, nor what else does not print.
  [[nodiscard]] static std::string word(const YAML::Node& node, const std::string& what) {
    auto text = as<std::string>(node, what);
    for (const char c : text) {
      if ((c >= 0 && c < ' ') || c == '\x7f')
        fail(node, what + ": a word is expected, not " + in_quotes(text));
    }
    return text;
  }
  /// Numbers of a flow or block sequence.
  [[nodiscard]] static std::vector<double> numbers(const YAML::Node& node, std::size_t count,
                                                   const std::string& what) {
    if (!node.IsSequence() || node.size() != count) {
      fail(node, what + ": a list of " + std::to_string(count) + " numbers is expected");
    }
    std::vector<double> values;
    for (const auto& entry : node) {
      values.push_back(as<double>(entry, what));
      if (!(values.back() - values.back() == 0)) fail(entry, what + ": a finite number is expected");
    }
    return values;
  }
  [[noreturn]] static void fail(const YAML::Node& node, const std::string& message) {
    const int line = node.Mark().line;
    throw Error((line >= 0 ? "line " + std::to_string(line + 1) + ": " : std::string()) + message);
  }

 private:
  YAML::Node node_;
};

}  // namespace vol::io
