// The part of OpenGL that OpenGL 3.3 core and OpenGL ES 3.0 share and that we draw with, loaded at run time.
// SPDX-License-Identifier: MIT
#pragma once

#include <GL/glcorearb.h>

namespace cupola {

struct GlFunctions {
  // State
  PFNGLGETERRORPROC get_error;
  PFNGLGETSTRINGPROC get_string;
  PFNGLGETINTEGERVPROC get_integerv;
  PFNGLENABLEPROC enable;
  PFNGLDISABLEPROC disable;
  PFNGLDEPTHFUNCPROC depth_func;
  PFNGLDEPTHMASKPROC depth_mask;
  PFNGLCOLORMASKPROC color_mask;
  PFNGLCULLFACEPROC cull_face;
  PFNGLFRONTFACEPROC front_face;
  PFNGLBLENDFUNCPROC blend_func;
  PFNGLPOLYGONOFFSETPROC polygon_offset;
  PFNGLVIEWPORTPROC viewport;
  PFNGLSCISSORPROC scissor;
  PFNGLPIXELSTOREIPROC pixel_storei;
  PFNGLFINISHPROC finish;
  // Frames
  PFNGLCLEARCOLORPROC clear_color;
  PFNGLCLEARPROC clear;
  PFNGLCLEARBUFFERFVPROC clear_bufferfv;
  PFNGLCLEARBUFFERIVPROC clear_bufferiv;
  PFNGLREADPIXELSPROC read_pixels;
  PFNGLREADBUFFERPROC read_buffer;
  PFNGLDRAWBUFFERSPROC draw_buffers;
  PFNGLGENFRAMEBUFFERSPROC gen_framebuffers;
  PFNGLDELETEFRAMEBUFFERSPROC delete_framebuffers;
  PFNGLBINDFRAMEBUFFERPROC bind_framebuffer;
  PFNGLFRAMEBUFFERTEXTURE2DPROC framebuffer_texture_2d;
  PFNGLFRAMEBUFFERTEXTURELAYERPROC framebuffer_texture_layer;
  PFNGLFRAMEBUFFERRENDERBUFFERPROC framebuffer_renderbuffer;
  PFNGLCHECKFRAMEBUFFERSTATUSPROC check_framebuffer_status;
  PFNGLBLITFRAMEBUFFERPROC blit_framebuffer;
  PFNGLGENRENDERBUFFERSPROC gen_renderbuffers;
  PFNGLDELETERENDERBUFFERSPROC delete_renderbuffers;
  PFNGLBINDRENDERBUFFERPROC bind_renderbuffer;
  PFNGLRENDERBUFFERSTORAGEPROC renderbuffer_storage;
  // Textures
  PFNGLGENTEXTURESPROC gen_textures;
  PFNGLDELETETEXTURESPROC delete_textures;
  PFNGLBINDTEXTUREPROC bind_texture;
  PFNGLACTIVETEXTUREPROC active_texture;
  PFNGLTEXIMAGE2DPROC tex_image_2d;
  PFNGLTEXSUBIMAGE2DPROC tex_sub_image_2d;
  PFNGLTEXIMAGE3DPROC tex_image_3d;
  PFNGLTEXSUBIMAGE3DPROC tex_sub_image_3d;
  PFNGLTEXPARAMETERIPROC tex_parameteri;
  PFNGLGENERATEMIPMAPPROC generate_mipmap;
  // Programs
  PFNGLCREATESHADERPROC create_shader;
  PFNGLDELETESHADERPROC delete_shader;
  PFNGLSHADERSOURCEPROC shader_source;
  PFNGLCOMPILESHADERPROC compile_shader;
  PFNGLGETSHADERIVPROC get_shaderiv;
  PFNGLGETSHADERINFOLOGPROC get_shader_info_log;
  PFNGLCREATEPROGRAMPROC create_program;
  PFNGLDELETEPROGRAMPROC delete_program;
  PFNGLATTACHSHADERPROC attach_shader;
  PFNGLBINDATTRIBLOCATIONPROC bind_attrib_location;
  PFNGLLINKPROGRAMPROC link_program;
  PFNGLGETPROGRAMIVPROC get_programiv;
  PFNGLGETPROGRAMINFOLOGPROC get_program_info_log;
  PFNGLUSEPROGRAMPROC use_program;
  PFNGLGETUNIFORMLOCATIONPROC get_uniform_location;
  PFNGLUNIFORM1IPROC uniform_1i;
  PFNGLUNIFORM1FPROC uniform_1f;
  PFNGLUNIFORM2FPROC uniform_2f;
  PFNGLUNIFORM3FPROC uniform_3f;
  PFNGLUNIFORM4FPROC uniform_4f;
  PFNGLUNIFORM3FVPROC uniform_3fv;
  PFNGLUNIFORM4FVPROC uniform_4fv;
  PFNGLUNIFORMMATRIX3FVPROC uniform_matrix_3fv;
  PFNGLUNIFORMMATRIX4FVPROC uniform_matrix_4fv;
  // Triangles
  PFNGLGENVERTEXARRAYSPROC gen_vertex_arrays;
  PFNGLDELETEVERTEXARRAYSPROC delete_vertex_arrays;
  PFNGLBINDVERTEXARRAYPROC bind_vertex_array;
  PFNGLGENBUFFERSPROC gen_buffers;
  PFNGLDELETEBUFFERSPROC delete_buffers;
  PFNGLBINDBUFFERPROC bind_buffer;
  PFNGLBUFFERDATAPROC buffer_data;
  PFNGLBUFFERSUBDATAPROC buffer_sub_data;
  PFNGLENABLEVERTEXATTRIBARRAYPROC enable_vertex_attrib_array;
  PFNGLVERTEXATTRIBPOINTERPROC vertex_attrib_pointer;
  PFNGLVERTEXATTRIBIPOINTERPROC vertex_attrib_ipointer;
  PFNGLDRAWARRAYSPROC draw_arrays;
  PFNGLDRAWELEMENTSPROC draw_elements;
};

using GlLoader = void (*(*)(const char* name))();
// The name of a function that is missing, or null.
const char* load_gl(GlFunctions& gl, GlLoader loader);

}  // namespace cupola
