"""PyTorch twins of taxel's networks, written from the papers and not from the Rust code.

`build(name, **settings)` returns a module whose `forward` takes the network's inputs in order and
whose `state_dict` names are taxel's.
"""

import torch
from torch import nn


def conv(dims):
    return nn.Conv1d if dims == 1 else nn.Conv2d


def norm(dims, channels):
    return (nn.BatchNorm1d if dims == 1 else nn.BatchNorm2d)(channels)


def max_pool(dims, *args, **kwargs):
    return (nn.MaxPool1d if dims == 1 else nn.MaxPool2d)(*args, **kwargs)


class ConvBn(nn.Module):
    """Convolution and batch norm, ReLU where asked for."""

    def __init__(self, dims, inputs, outputs, kernel, stride=1, relu=True):
        super().__init__()
        self.conv = conv(dims)(inputs, outputs, kernel, stride=stride, padding=kernel // 2)
        self.bn = norm(dims, outputs)
        self.relu = relu

    def forward(self, x):
        x = self.bn(self.conv(x))
        return torch.relu(x) if self.relu else x


class Vgg6Lite(nn.Module):
    """Paper 000, section 3.1.1."""

    width = 64

    def __init__(self, dims, inputs):
        super().__init__()
        widths = [inputs, 16, 32, 64, 64, 64]
        self.convs = nn.ModuleList(ConvBn(dims, a, b, 3) for a, b in zip(widths, widths[1:]))
        self.pools = [max_pool(dims, 2, 2, ceil_mode=True) if i in (0, 1, 4) else nn.Identity() for i in range(5)]

    def forward(self, x):
        for block, pool in zip(self.convs, self.pools):
            x = pool(block(x))
        return x.flatten(2).mean(2)


class Residual(nn.Module):
    def __init__(self, dims, inputs, outputs, stride):
        super().__init__()
        self.conv1 = ConvBn(dims, inputs, outputs, 3, stride)
        self.conv2 = ConvBn(dims, outputs, outputs, 3, relu=False)
        if stride > 1:
            self.shortcut = ConvBn(dims, inputs, outputs, 1, stride, relu=False)

    def forward(self, x):
        skip = self.shortcut(x) if hasattr(self, "shortcut") else x
        return torch.relu(self.conv2(self.conv1(x)) + skip)


class ResNet8Lite(nn.Module):
    """Paper 000, section 3.1.2."""

    width = 32

    def __init__(self, dims, inputs):
        super().__init__()
        self.stem = ConvBn(dims, inputs, 16, 5)
        self.pool = max_pool(dims, 3, 2, padding=1)
        self.identity1 = Residual(dims, 16, 16, 1)
        self.downsample = Residual(dims, 16, 32, 2)
        self.identity2 = Residual(dims, 32, 32, 1)

    def forward(self, x):
        x = self.pool(self.stem(x))
        return self.identity2(self.downsample(self.identity1(x))).flatten(2).mean(2)


class Dense(nn.Module):
    def __init__(self, dims, inputs):
        super().__init__()
        self.bn1 = norm(dims, inputs)
        self.conv1 = conv(dims)(inputs, 64, 1)
        self.bn2 = norm(dims, 64)
        self.conv2 = conv(dims)(64, 16, 3, padding=1)

    def forward(self, x):
        grown = self.conv2(torch.relu(self.bn2(self.conv1(torch.relu(self.bn1(x))))))
        return torch.cat([x, grown], 1)


class DenseNet6Lite(nn.Module):
    """Paper 000, section 3.1.3."""

    width = 48

    def __init__(self, dims, inputs):
        super().__init__()
        self.stem = ConvBn(dims, inputs, 16, 5)
        self.pool = max_pool(dims, 3, 2, padding=1)
        self.block1 = Dense(dims, 16)
        self.transition = (nn.AvgPool1d if dims == 1 else nn.AvgPool2d)(2)
        self.block2 = Dense(dims, 32)
        self.norm = norm(dims, 48)

    def forward(self, x):
        x = self.block2(self.transition(self.block1(self.pool(self.stem(x)))))
        return torch.relu(self.norm(x)).flatten(2).mean(2)


class Hybrid(nn.Module):
    """Paper 000, section 3.2."""

    def __init__(self, temporal, spatial, fuse, in_channels, image_channels, classes):
        super().__init__()
        self.temporal = temporal(1, in_channels)
        self.spatial = spatial(2, image_channels)
        width = temporal.width + spatial.width
        if fuse:
            self.fuse = nn.Linear(width, width // 2)
            width //= 2
        self.fc = nn.Linear(width, classes)

    def forward(self, signal, image):
        joined = torch.cat([self.temporal(signal), self.spatial(image)], 1)
        if hasattr(self, "fuse"):
            joined = torch.relu(self.fuse(joined))
        return self.fc(joined)


class Mlp(nn.Module):
    """Paper 000, Table 5."""

    def __init__(self, in_features, hidden, classes):
        super().__init__()
        self.fc1 = nn.Linear(in_features, hidden)
        self.fc2 = nn.Linear(hidden, classes)

    def forward(self, signal):
        return self.fc2(torch.relu(self.fc1(signal.flatten(1))))


BODIES = {"vgg6-lite": Vgg6Lite, "resnet8-lite": ResNet8Lite, "densenet6-lite": DenseNet6Lite}
HYBRIDS = {
    "hybrid-vgg": (Vgg6Lite, Vgg6Lite, True),
    "hybrid-resnet": (ResNet8Lite, ResNet8Lite, True),
    "hybrid-densenet": (DenseNet6Lite, DenseNet6Lite, True),
    "hybrid-resvgg": (ResNet8Lite, Vgg6Lite, True),
    "hybrid-resvgg-nofc": (ResNet8Lite, Vgg6Lite, False),
}


def add_classifier(body, classes):
    """The body becomes the network: its own names, with `fc` after the pooled features."""
    body.fc = nn.Linear(body.width, classes)
    features = body.forward
    body.forward = lambda x: body.fc(features(x))
    return body


def build(name, classes=3, in_channels=None, image_channels=3, in_features=250, hidden=128, **_sizes):
    """The network `name`; sizes of the inputs beyond their channels do not matter here."""
    if name == "mlp":
        return Mlp(in_features, hidden, classes)
    if name in HYBRIDS:
        temporal, spatial, fuse = HYBRIDS[name]
        return Hybrid(temporal, spatial, fuse, in_channels or 5, image_channels, classes)
    body, dims = name.rsplit("-", 1)
    dims = int(dims[0])
    return add_classifier(BODIES[body](dims, in_channels or (5 if dims == 1 else 3)), classes)


def input_shapes(name, classes=3, in_channels=None, image_channels=3, length=50, height=50, width=50, in_features=250, **_):
    """Shapes of the inputs in order, batch axis left out."""
    if name == "mlp":
        return [(1, in_features)]
    if name in HYBRIDS:
        return [(in_channels or 5, length), (image_channels, height, width)]
    return [(in_channels or 5, length)] if name.endswith("1d") else [(in_channels or 3, height, width)]
