// GlFunctions: the OpenGL functions a volume slicer needs, as a table that belongs to one context.
//
// There are no global function pointers: two contexts of two libraries live side by side, each with
// its own table. A member is called like the function without its prefix, gl.TexSubImage3D(...).
// The functions of GL 3.3 are never null; those named optional below are null unless the context
// has the version or the extension given with them. Constants (GL_TEXTURE_3D, ...) come from
// GL/glcorearb.h, which declares no functions here, so that nothing can link to libGL by mistake. A
// file that needs GL/gl.h too (osmesa.h, a toolkit's header) includes it after this one.
//
// A table may be used on the thread only on which its context is current.
#pragma once

#include <GL/glcorearb.h>

#include <functional>

namespace sluice {

// Finds a function by its full name ("glClear"); null when there is none.
using GlLoader = std::function<void*(const char*)>;

// X(name, NAME): required, GL 3.3.
#define SLUICE_GL_REQUIRED_FUNCTIONS(X)                       \
  /* State and queries */                                     \
  X(GetString, GETSTRING)                                     \
  X(GetStringi, GETSTRINGI)                                   \
  X(GetIntegerv, GETINTEGERV)                                 \
  X(GetInteger64v, GETINTEGER64V)                             \
  X(GetFloatv, GETFLOATV)                                     \
  X(GetBooleanv, GETBOOLEANV)                                 \
  X(GetError, GETERROR)                                       \
  X(Enable, ENABLE)                                           \
  X(Disable, DISABLE)                                         \
  X(Enablei, ENABLEI)                                         \
  X(Disablei, DISABLEI)                                       \
  X(IsEnabled, ISENABLED)                                     \
  X(Hint, HINT)                                               \
  X(Flush, FLUSH)                                             \
  X(Finish, FINISH)                                           \
  X(PixelStorei, PIXELSTOREI)                                 \
  /* Rasterisation, tests and blending */                     \
  X(Viewport, VIEWPORT)                                       \
  X(Scissor, SCISSOR)                                         \
  X(CullFace, CULLFACE)                                       \
  X(FrontFace, FRONTFACE)                                     \
  X(PolygonMode, POLYGONMODE)                                 \
  X(PolygonOffset, POLYGONOFFSET)                             \
  X(LineWidth, LINEWIDTH)                                     \
  X(PointSize, POINTSIZE)                                     \
  X(DepthFunc, DEPTHFUNC)                                     \
  X(DepthMask, DEPTHMASK)                                     \
  X(DepthRange, DEPTHRANGE)                                   \
  X(StencilFunc, STENCILFUNC)                                 \
  X(StencilFuncSeparate, STENCILFUNCSEPARATE)                 \
  X(StencilMask, STENCILMASK)                                 \
  X(StencilOp, STENCILOP)                                     \
  X(StencilOpSeparate, STENCILOPSEPARATE)                     \
  X(ColorMask, COLORMASK)                                     \
  X(ColorMaski, COLORMASKI)                                   \
  X(BlendColor, BLENDCOLOR)                                   \
  X(BlendEquation, BLENDEQUATION)                             \
  X(BlendEquationSeparate, BLENDEQUATIONSEPARATE)             \
  X(BlendFunc, BLENDFUNC)                                     \
  X(BlendFuncSeparate, BLENDFUNCSEPARATE)                     \
  X(LogicOp, LOGICOP)                                         \
  /* Clearing, copying and reading back */                    \
  X(Clear, CLEAR)                                             \
  X(ClearColor, CLEARCOLOR)                                   \
  X(ClearDepth, CLEARDEPTH)                                   \
  X(ClearStencil, CLEARSTENCIL)                               \
  X(ClearBufferfv, CLEARBUFFERFV)                             \
  X(ClearBufferiv, CLEARBUFFERIV)                             \
  X(ClearBufferuiv, CLEARBUFFERUIV)                           \
  X(ClearBufferfi, CLEARBUFFERFI)                             \
  X(ReadBuffer, READBUFFER)                                   \
  X(ReadPixels, READPIXELS)                                   \
  X(BlitFramebuffer, BLITFRAMEBUFFER)                         \
  X(DrawBuffer, DRAWBUFFER)                                   \
  X(DrawBuffers, DRAWBUFFERS)                                 \
  /* Textures and samplers */                                 \
  X(ActiveTexture, ACTIVETEXTURE)                             \
  X(GenTextures, GENTEXTURES)                                 \
  X(DeleteTextures, DELETETEXTURES)                           \
  X(BindTexture, BINDTEXTURE)                                 \
  X(TexParameteri, TEXPARAMETERI)                             \
  X(TexParameteriv, TEXPARAMETERIV)                           \
  X(TexParameterf, TEXPARAMETERF)                             \
  X(TexParameterfv, TEXPARAMETERFV)                           \
  X(GetTexLevelParameteriv, GETTEXLEVELPARAMETERIV)           \
  X(TexImage1D, TEXIMAGE1D)                                   \
  X(TexImage2D, TEXIMAGE2D)                                   \
  X(TexImage3D, TEXIMAGE3D)                                   \
  X(TexSubImage1D, TEXSUBIMAGE1D)                             \
  X(TexSubImage2D, TEXSUBIMAGE2D)                             \
  X(TexSubImage3D, TEXSUBIMAGE3D)                             \
  X(CopyTexSubImage2D, COPYTEXSUBIMAGE2D)                     \
  X(CopyTexSubImage3D, COPYTEXSUBIMAGE3D)                     \
  X(GetTexImage, GETTEXIMAGE)                                 \
  X(GenerateMipmap, GENERATEMIPMAP)                           \
  X(TexBuffer, TEXBUFFER)                                     \
  X(GenSamplers, GENSAMPLERS)                                 \
  X(DeleteSamplers, DELETESAMPLERS)                           \
  X(BindSampler, BINDSAMPLER)                                 \
  X(SamplerParameteri, SAMPLERPARAMETERI)                     \
  X(SamplerParameterfv, SAMPLERPARAMETERFV)                   \
  /* Buffers, pixel buffers and uniform buffers included */   \
  X(GenBuffers, GENBUFFERS)                                   \
  X(DeleteBuffers, DELETEBUFFERS)                             \
  X(BindBuffer, BINDBUFFER)                                   \
  X(BindBufferBase, BINDBUFFERBASE)                           \
  X(BindBufferRange, BINDBUFFERRANGE)                         \
  X(BufferData, BUFFERDATA)                                   \
  X(BufferSubData, BUFFERSUBDATA)                             \
  X(CopyBufferSubData, COPYBUFFERSUBDATA)                     \
  X(GetBufferSubData, GETBUFFERSUBDATA)                       \
  X(MapBuffer, MAPBUFFER)                                     \
  X(MapBufferRange, MAPBUFFERRANGE)                           \
  X(FlushMappedBufferRange, FLUSHMAPPEDBUFFERRANGE)           \
  X(UnmapBuffer, UNMAPBUFFER)                                 \
  /* Vertex arrays and drawing */                             \
  X(GenVertexArrays, GENVERTEXARRAYS)                         \
  X(DeleteVertexArrays, DELETEVERTEXARRAYS)                   \
  X(BindVertexArray, BINDVERTEXARRAY)                         \
  X(EnableVertexAttribArray, ENABLEVERTEXATTRIBARRAY)         \
  X(DisableVertexAttribArray, DISABLEVERTEXATTRIBARRAY)       \
  X(VertexAttribPointer, VERTEXATTRIBPOINTER)                 \
  X(VertexAttribIPointer, VERTEXATTRIBIPOINTER)               \
  X(VertexAttribDivisor, VERTEXATTRIBDIVISOR)                 \
  X(VertexAttrib4f, VERTEXATTRIB4F)                           \
  X(PrimitiveRestartIndex, PRIMITIVERESTARTINDEX)             \
  X(DrawArrays, DRAWARRAYS)                                   \
  X(DrawArraysInstanced, DRAWARRAYSINSTANCED)                 \
  X(DrawElements, DRAWELEMENTS)                               \
  X(DrawElementsBaseVertex, DRAWELEMENTSBASEVERTEX)           \
  X(DrawElementsInstanced, DRAWELEMENTSINSTANCED)             \
  X(DrawRangeElements, DRAWRANGEELEMENTS)                     \
  X(MultiDrawArrays, MULTIDRAWARRAYS)                         \
  X(MultiDrawElements, MULTIDRAWELEMENTS)                     \
  /* Framebuffers */                                          \
  X(GenFramebuffers, GENFRAMEBUFFERS)                         \
  X(DeleteFramebuffers, DELETEFRAMEBUFFERS)                   \
  X(BindFramebuffer, BINDFRAMEBUFFER)                         \
  X(CheckFramebufferStatus, CHECKFRAMEBUFFERSTATUS)           \
  X(FramebufferTexture, FRAMEBUFFERTEXTURE)                   \
  X(FramebufferTexture2D, FRAMEBUFFERTEXTURE2D)               \
  X(FramebufferTextureLayer, FRAMEBUFFERTEXTURELAYER)         \
  X(FramebufferRenderbuffer, FRAMEBUFFERRENDERBUFFER)         \
  X(GenRenderbuffers, GENRENDERBUFFERS)                       \
  X(DeleteRenderbuffers, DELETERENDERBUFFERS)                 \
  X(BindRenderbuffer, BINDRENDERBUFFER)                       \
  X(RenderbufferStorage, RENDERBUFFERSTORAGE)                 \
  /* Shaders, programs and uniforms */                        \
  X(CreateShader, CREATESHADER)                               \
  X(DeleteShader, DELETESHADER)                               \
  X(ShaderSource, SHADERSOURCE)                               \
  X(CompileShader, COMPILESHADER)                             \
  X(GetShaderiv, GETSHADERIV)                                 \
  X(GetShaderInfoLog, GETSHADERINFOLOG)                       \
  X(CreateProgram, CREATEPROGRAM)                             \
  X(DeleteProgram, DELETEPROGRAM)                             \
  X(AttachShader, ATTACHSHADER)                               \
  X(DetachShader, DETACHSHADER)                               \
  X(BindAttribLocation, BINDATTRIBLOCATION)                   \
  X(BindFragDataLocation, BINDFRAGDATALOCATION)               \
  X(BindFragDataLocationIndexed, BINDFRAGDATALOCATIONINDEXED) \
  X(LinkProgram, LINKPROGRAM)                                 \
  X(ValidateProgram, VALIDATEPROGRAM)                         \
  X(UseProgram, USEPROGRAM)                                   \
  X(GetProgramiv, GETPROGRAMIV)                               \
  X(GetProgramInfoLog, GETPROGRAMINFOLOG)                     \
  X(GetAttribLocation, GETATTRIBLOCATION)                     \
  X(GetUniformLocation, GETUNIFORMLOCATION)                   \
  X(GetUniformBlockIndex, GETUNIFORMBLOCKINDEX)               \
  X(UniformBlockBinding, UNIFORMBLOCKBINDING)                 \
  X(GetActiveUniform, GETACTIVEUNIFORM)                       \
  X(Uniform1i, UNIFORM1I)                                     \
  X(Uniform2i, UNIFORM2I)                                     \
  X(Uniform3i, UNIFORM3I)                                     \
  X(Uniform4i, UNIFORM4I)                                     \
  X(Uniform1ui, UNIFORM1UI)                                   \
  X(Uniform1iv, UNIFORM1IV)                                   \
  X(Uniform1f, UNIFORM1F)                                     \
  X(Uniform2f, UNIFORM2F)                                     \
  X(Uniform3f, UNIFORM3F)                                     \
  X(Uniform4f, UNIFORM4F)                                     \
  X(Uniform1fv, UNIFORM1FV)                                   \
  X(Uniform2fv, UNIFORM2FV)                                   \
  X(Uniform3fv, UNIFORM3FV)                                   \
  X(Uniform4fv, UNIFORM4FV)                                   \
  X(UniformMatrix3fv, UNIFORMMATRIX3FV)                       \
  X(UniformMatrix4fv, UNIFORMMATRIX4FV)                       \
  /* Queries and fences */                                    \
  X(GenQueries, GENQUERIES)                                   \
  X(DeleteQueries, DELETEQUERIES)                             \
  X(BeginQuery, BEGINQUERY)                                   \
  X(EndQuery, ENDQUERY)                                       \
  X(QueryCounter, QUERYCOUNTER)                               \
  X(GetQueryObjectiv, GETQUERYOBJECTIV)                       \
  X(GetQueryObjectuiv, GETQUERYOBJECTUIV)                     \
  X(GetQueryObjectui64v, GETQUERYOBJECTUI64V)                 \
  X(BeginConditionalRender, BEGINCONDITIONALRENDER)           \
  X(EndConditionalRender, ENDCONDITIONALRENDER)               \
  X(FenceSync, FENCESYNC)                                     \
  X(ClientWaitSync, CLIENTWAITSYNC)                           \
  X(WaitSync, WAITSYNC)                                       \
  X(DeleteSync, DELETESYNC)

// X(name, NAME, version, extension): null unless the context's versionNumber() reaches `version` or
// it has `extension`.
#define SLUICE_GL_OPTIONAL_FUNCTIONS(X)                                                           \
  X(BlendEquationi, BLENDEQUATIONI, 40, "GL_ARB_draw_buffers_blend")                              \
  X(BlendEquationSeparatei, BLENDEQUATIONSEPARATEI, 40, "GL_ARB_draw_buffers_blend")              \
  X(BlendFunci, BLENDFUNCI, 40, "GL_ARB_draw_buffers_blend")                                      \
  X(BlendFuncSeparatei, BLENDFUNCSEPARATEI, 40, "GL_ARB_draw_buffers_blend")                      \
  X(TexStorage1D, TEXSTORAGE1D, 42, "GL_ARB_texture_storage")                                     \
  X(TexStorage2D, TEXSTORAGE2D, 42, "GL_ARB_texture_storage")                                     \
  X(TexStorage3D, TEXSTORAGE3D, 42, "GL_ARB_texture_storage")                                     \
  X(DrawArraysInstancedBaseInstance, DRAWARRAYSINSTANCEDBASEINSTANCE, 42, "GL_ARB_base_instance") \
  X(BindImageTexture, BINDIMAGETEXTURE, 42, "GL_ARB_shader_image_load_store")                     \
  X(MemoryBarrier, MEMORYBARRIER, 42, "GL_ARB_shader_image_load_store")                           \
  X(MultiDrawArraysIndirect, MULTIDRAWARRAYSINDIRECT, 43, "GL_ARB_multi_draw_indirect")           \
  X(CopyImageSubData, COPYIMAGESUBDATA, 43, "GL_ARB_copy_image")                                  \
  X(InvalidateTexImage, INVALIDATETEXIMAGE, 43, "GL_ARB_invalidate_subdata")                      \
  X(InvalidateFramebuffer, INVALIDATEFRAMEBUFFER, 43, "GL_ARB_invalidate_subdata")                \
  X(DebugMessageCallback, DEBUGMESSAGECALLBACK, 43, "GL_KHR_debug")                               \
  X(DebugMessageControl, DEBUGMESSAGECONTROL, 43, "GL_KHR_debug")                                 \
  X(BufferStorage, BUFFERSTORAGE, 44, "GL_ARB_buffer_storage")                                    \
  X(ClearTexImage, CLEARTEXIMAGE, 44, "GL_ARB_clear_texture")                                     \
  X(ClearTexSubImage, CLEARTEXSUBIMAGE, 44, "GL_ARB_clear_texture")                               \
  X(TextureBarrier, TEXTUREBARRIER, 45, "GL_ARB_texture_barrier")

struct GlFunctions {
#define SLUICE_GL_MEMBER(name, NAME, ...) PFNGL##NAME##PROC name = nullptr;
  SLUICE_GL_REQUIRED_FUNCTIONS(SLUICE_GL_MEMBER)
  SLUICE_GL_OPTIONAL_FUNCTIONS(SLUICE_GL_MEMBER)
#undef SLUICE_GL_MEMBER
};

// The table of the context that is current. The optional functions are asked of the context's
// version and extensions first, because Mesa's loaders hand out stubs for functions that they lack.
// Throws Error when the context is older than 3.3 or a required function is missing, naming it.
GlFunctions loadGlFunctions(const GlLoader& loader);

}  // namespace sluice
