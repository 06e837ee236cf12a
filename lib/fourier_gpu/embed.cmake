# cmake -DOUTPUT=shaders.h -DFOLDER=... -P embed.cmake: the shaders as C++ strings.
set(text "#pragma once\n\nnamespace vol::fourier_gpu {\n")
foreach(pair "kSliceShader;slice.comp" "kFftShader;fft.comp")
  list(GET pair 0 name)
  list(GET pair 1 file)
  file(READ ${FOLDER}/${file} source)
  string(APPEND text "inline constexpr const char* ${name} = R\"glsl(${source})glsl\";\n")
endforeach()
file(WRITE ${OUTPUT} "${text}}  // namespace vol::fourier_gpu\n")
