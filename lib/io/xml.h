#pragma once
#include <map>
#include <string>
#include <string_view>

// Private to lib/io: as much XML as VTK's files use.
namespace vol::io {

struct XmlTag {
  enum class Kind { open, close, empty, end_of_text };
  Kind kind = Kind::end_of_text;
  std::string name;
  std::map<std::string, std::string> attributes;

  /// Value of an attribute, "" where it is missing.
  [[nodiscard]] std::string operator[](const char* attribute) const {
    const auto found = attributes.find(attribute);
    return found == attributes.end() ? std::string() : found->second;
  }
};

/// Goes through the tags of a text; comments, declarations and processing instructions are passed over.
class XmlReader {
 public:
  XmlReader(std::string file, std::string_view text) : file_(std::move(file)), text_(text) {}
  /// The next tag; throws vol::Error, naming the file, where the text is not XML.
  [[nodiscard]] XmlTag next();
  /// Text from here to the next '<'; for data between tags.
  [[nodiscard]] std::string_view text_here() const;

 private:
  std::string file_;
  std::string_view text_;
  std::size_t at_ = 0;
  [[noreturn]] void refuse(const char* what) const;
  void skip_space();
  void skip_past(std::string_view mark);
  [[nodiscard]] std::string name();
};

/// Text for use in an attribute or between tags.
[[nodiscard]] std::string xml_escaped(std::string_view text);

}  // namespace vol::io
