"""What there is to choose from, found where Drake and OMPL are loaded."""

from planning import describe_model, list_models
from planning.api.planners import list_planners
from service.catalog.models import ModelList, Planner, PlannerList
from service.catalog.tasks import LIST_MODELS, LIST_PLANNERS, SHOW_MODEL, ModelWork, NoWork
from service.jobs.context import TaskContext
from service.scenes.models.summary import Model
from service.scenes.tasks import LibraryWork
from service.scenes.world_cache import library_of


@LIST_MODELS.runs
def name_models(work: LibraryWork, _: TaskContext) -> ModelList:
    """Return the names of all robots."""
    return ModelList(items=list(list_models(library_of(work.library))))


@SHOW_MODEL.runs
def show_model(work: ModelWork, _: TaskContext) -> Model:
    """Return what a robot can do.

    Raises:
        UnknownName: There is none of that name.
        ModelInvalid: It does not load.
    """
    return Model.from_summary(describe_model(library_of(work.library), work.name))


@LIST_PLANNERS.runs
def name_planners(_: NoWork, __: TaskContext) -> PlannerList:
    """Return all planners with their parameters."""
    return PlannerList(items=[Planner.model_validate(card) for card in list_planners()])
