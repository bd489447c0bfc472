// One line a function: where it goes and its name.
// SPDX-License-Identifier: MIT
#include "hal/gl/gl_functions.h"

namespace cupola {
namespace {

class Loading {
 public:
  explicit Loading(GlLoader loader) : loader_(loader) {}
  template <class Function>
  void operator()(Function& function, const char* name) {
    function = reinterpret_cast<Function>(loader_(name));
    if (!function && !missing_) missing_ = name;
  }
  const char* missing() const { return missing_; }

 private:
  GlLoader loader_;
  const char* missing_ = nullptr;
};

}  // namespace

const char* load_gl(GlFunctions& gl, GlLoader loader) {
  Loading load(loader);
  load(gl.get_error, "glGetError");
  load(gl.get_string, "glGetString");
  load(gl.get_integerv, "glGetIntegerv");
  load(gl.enable, "glEnable");
  load(gl.disable, "glDisable");
  load(gl.depth_func, "glDepthFunc");
  load(gl.depth_mask, "glDepthMask");
  load(gl.color_mask, "glColorMask");
  load(gl.cull_face, "glCullFace");
  load(gl.front_face, "glFrontFace");
  load(gl.blend_func, "glBlendFunc");
  load(gl.polygon_offset, "glPolygonOffset");
  load(gl.viewport, "glViewport");
  load(gl.scissor, "glScissor");
  load(gl.pixel_storei, "glPixelStorei");
  load(gl.finish, "glFinish");
  load(gl.clear_color, "glClearColor");
  load(gl.clear, "glClear");
  load(gl.clear_bufferfv, "glClearBufferfv");
  load(gl.clear_bufferiv, "glClearBufferiv");
  load(gl.read_pixels, "glReadPixels");
  load(gl.read_buffer, "glReadBuffer");
  load(gl.draw_buffers, "glDrawBuffers");
  load(gl.gen_framebuffers, "glGenFramebuffers");
  load(gl.delete_framebuffers, "glDeleteFramebuffers");
  load(gl.bind_framebuffer, "glBindFramebuffer");
  load(gl.framebuffer_texture_2d, "glFramebufferTexture2D");
  load(gl.framebuffer_texture_layer, "glFramebufferTextureLayer");
  load(gl.framebuffer_renderbuffer, "glFramebufferRenderbuffer");
  load(gl.check_framebuffer_status, "glCheckFramebufferStatus");
  load(gl.blit_framebuffer, "glBlitFramebuffer");
  load(gl.gen_renderbuffers, "glGenRenderbuffers");
  load(gl.delete_renderbuffers, "glDeleteRenderbuffers");
  load(gl.bind_renderbuffer, "glBindRenderbuffer");
  load(gl.renderbuffer_storage, "glRenderbufferStorage");
  load(gl.gen_textures, "glGenTextures");
  load(gl.delete_textures, "glDeleteTextures");
  load(gl.bind_texture, "glBindTexture");
  load(gl.active_texture, "glActiveTexture");
  load(gl.tex_image_2d, "glTexImage2D");
  load(gl.tex_sub_image_2d, "glTexSubImage2D");
  load(gl.tex_image_3d, "glTexImage3D");
  load(gl.tex_sub_image_3d, "glTexSubImage3D");
  load(gl.tex_parameteri, "glTexParameteri");
  load(gl.generate_mipmap, "glGenerateMipmap");
  load(gl.create_shader, "glCreateShader");
  load(gl.delete_shader, "glDeleteShader");
  load(gl.shader_source, "glShaderSource");
  load(gl.compile_shader, "glCompileShader");
  load(gl.get_shaderiv, "glGetShaderiv");
  load(gl.get_shader_info_log, "glGetShaderInfoLog");
  load(gl.create_program, "glCreateProgram");
  load(gl.delete_program, "glDeleteProgram");
  load(gl.attach_shader, "glAttachShader");
  load(gl.bind_attrib_location, "glBindAttribLocation");
  load(gl.link_program, "glLinkProgram");
  load(gl.get_programiv, "glGetProgramiv");
  load(gl.get_program_info_log, "glGetProgramInfoLog");
  load(gl.use_program, "glUseProgram");
  load(gl.get_uniform_location, "glGetUniformLocation");
  load(gl.uniform_1i, "glUniform1i");
  load(gl.uniform_1f, "glUniform1f");
  load(gl.uniform_2f, "glUniform2f");
  load(gl.uniform_3f, "glUniform3f");
  load(gl.uniform_4f, "glUniform4f");
  load(gl.uniform_3fv, "glUniform3fv");
  load(gl.uniform_4fv, "glUniform4fv");
  load(gl.uniform_matrix_3fv, "glUniformMatrix3fv");
  load(gl.uniform_matrix_4fv, "glUniformMatrix4fv");
  load(gl.gen_vertex_arrays, "glGenVertexArrays");
  load(gl.delete_vertex_arrays, "glDeleteVertexArrays");
  load(gl.bind_vertex_array, "glBindVertexArray");
  load(gl.gen_buffers, "glGenBuffers");
  load(gl.delete_buffers, "glDeleteBuffers");
  load(gl.bind_buffer, "glBindBuffer");
  load(gl.buffer_data, "glBufferData");
  load(gl.buffer_sub_data, "glBufferSubData");
  load(gl.enable_vertex_attrib_array, "glEnableVertexAttribArray");
  load(gl.vertex_attrib_pointer, "glVertexAttribPointer");
  load(gl.vertex_attrib_ipointer, "glVertexAttribIPointer");
  load(gl.draw_arrays, "glDrawArrays");
  load(gl.draw_elements, "glDrawElements");
  return load.missing();
}

}  // namespace cupola
