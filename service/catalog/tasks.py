"""Tasks that tell what there is to choose from."""

from service.catalog.models import ModelList, PlannerList
from service.jobs.task import Task, TaskModel
from service.scenes.models.summary import Model
from service.scenes.tasks import LibraryWork


class NoWork(TaskModel):
    """Nothing."""


class ModelWork(LibraryWork):
    """Which robot is asked for."""

    name: str


LIST_MODELS = Task("list_models", LibraryWork, ModelList)
SHOW_MODEL = Task("show_model", ModelWork, Model)
LIST_PLANNERS = Task("list_planners", NoWork, PlannerList)
