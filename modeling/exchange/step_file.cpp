#include "modeling/exchange/step_file.h"

#include <fmt/format.h>

#include <APIHeaderSection_MakeHeader.hxx>
#include <Interface_Protocol.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <StepBasic_Product.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopoDS_Shape.hxx>
#include <XSControl_WorkSession.hxx>
#include <mutex>
#include <sstream>

namespace annulus {
namespace {

Handle(TCollection_HAsciiString) Ascii(const std::string& text) { return new TCollection_HAsciiString(text.c_str()); }

/// Gives the products that were added since `first` their name.
void NameProducts(const Handle(StepData_StepModel) & model, int first, const std::string& name) {
  for (int k = first + 1; k <= model->NbEntities(); ++k) {
    const Handle(StepBasic_Product) product = Handle(StepBasic_Product)::DownCast(model->Value(k));
    if (product.IsNull()) continue;
    product->SetId(Ascii(name));
    product->SetName(Ascii(name));
  }
}

void FillHeader(const Handle(StepData_StepModel) & model, const std::string& title) {
  APIHeaderSection_MakeHeader header(model);
  header.SetName(Ascii(title));
  header.SetTimeStamp(Ascii("2000-01-01T00:00:00"));
  header.SetAuthorValue(1, Ascii(""));
  header.SetOrganizationValue(1, Ascii(""));
  header.SetPreprocessorVersion(Ascii("Open CASCADE 7.6"));
  header.SetOriginatingSystem(Ascii("annulus"));
  header.SetAuthorisation(Ascii(""));
  header.SetDescriptionValue(1, Ascii(title));
}

}  // namespace

Result<std::string> StepText(const std::vector<SolidBody>& bodies, const std::string& title) {
  // Open CASCADE keeps its options and its messages in globals.
  static std::mutex occt_globals;
  const std::lock_guard lock(occt_globals);
  const std::string attempted = "write STEP";
  try {
    Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
    STEPControl_Writer writer;
    Interface_Static::SetCVal("write.step.schema", "AP214IS");
    Interface_Static::SetCVal("write.step.unit", "MM");
    Interface_Static::SetIVal("write.step.assembly", 0);
    const Handle(StepData_StepModel) model = writer.Model();
    for (const SolidBody& body : bodies) {
      const bool several = body.shapes().size() > 1;
      for (std::size_t k = 0; k < body.shapes().size(); ++k) {
        const int before = model->NbEntities();
        if (writer.Transfer(body.shapes()[k], STEPControl_ManifoldSolidBrep) != IFSelect_RetDone) {
          return Fail(attempted, "Open CASCADE does not transfer " + body.name(), "report this design");
        }
        NameProducts(model, before, several ? fmt::format("{}_{}", body.name(), k + 1) : body.name());
      }
    }
    FillHeader(model, title);
    StepData_StepWriter text(model);
    text.SendModel(Handle(StepData_Protocol)::DownCast(writer.WS()->Protocol()));
    std::ostringstream out;
    if (!text.Print(out)) return Fail(attempted, "Open CASCADE does not print the file", "report this design");
    return out.str();
  } catch (const Standard_Failure& failure) {
    return Fail(attempted, std::string("Open CASCADE says ") + failure.GetMessageString(), "report this design");
  }
}

}  // namespace annulus
