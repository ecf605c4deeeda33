"""PyTorch twins of taxel's networks, written from the papers and not from the Rust code.

`build(name, **settings)` returns a module whose `forward` takes the network's inputs in order and
whose `state_dict` names are taxel's.
"""

from collections import OrderedDict

import numpy as np
import torch
from torch import nn

import image_networks


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


class Lstm(nn.Module):
    """Paper 000, Table 5: the last hidden state of one layer that reads the sensors step by step."""

    def __init__(self, in_channels, hidden, classes):
        super().__init__()
        self.lstm = nn.LSTM(in_channels, hidden, batch_first=True)
        self.fc = nn.Linear(hidden, classes)

    def forward(self, signal):
        outputs, _ = self.lstm(signal.transpose(1, 2))
        return self.fc(outputs[:, -1])


class TactNet(nn.Module):
    """Gandarias et al. 2019: convolutions of 5, then 3, each followed by a pool."""

    def __init__(self, inputs, widths, height, width, classes):
        super().__init__()
        self.convs = nn.ModuleList(ConvBn(2, a, b, 3 if i else 5) for i, (a, b) in enumerate(zip([inputs, *widths], widths)))
        for _ in widths:
            height, width = -(-height // 2), -(-width // 2)
        self.fc = nn.Linear(widths[-1] * height * width, classes)

    def forward(self, x):
        for block in self.convs:
            x = nn.functional.max_pool2d(block(x), 2, 2, ceil_mode=True)
        return self.fc(x.flatten(1))


class TactBlock(nn.Module):
    def __init__(self, inputs, outputs):
        super().__init__()
        self.conv1 = ConvBn(2, inputs, outputs, 3)
        self.conv2 = ConvBn(2, outputs, outputs, 3, relu=False)
        if inputs != outputs:
            self.shortcut = ConvBn(2, inputs, outputs, 3, relu=False)

    def forward(self, x):
        skip = self.shortcut(x) if hasattr(self, "shortcut") else x
        return torch.relu(self.conv2(self.conv1(x)) + skip)


class TactResNet(nn.Module):
    """Gandarias et al. 2019: four residual blocks between two pools."""

    def __init__(self, inputs, height, width, classes):
        super().__init__()
        self.stem = ConvBn(2, inputs, 64, 5, stride=2)
        self.res2, self.res3 = TactBlock(64, 64), TactBlock(64, 64)
        self.res4, self.res5 = TactBlock(64, 128), TactBlock(128, 128)
        after = [((size - 1) // 2 + 1 - 3) // 2 + 1 - 4 for size in (height, width)]
        self.fc = nn.Linear(128 * after[0] * after[1], classes)

    def forward(self, x):
        x = nn.functional.max_pool2d(self.stem(x), 3, 2)
        x = self.res5(self.res4(self.res3(self.res2(x))))
        return self.fc(nn.functional.max_pool2d(x, 5, 1).flatten(1))


class TactNet3d(nn.Module):
    """Papers 002 and 003: unpadded 3D convolutions, by default without a pool."""

    def __init__(self, filters, kernels, classes, in_channels=1, height=28, width=50, frames=10, hidden=64, pool=1, dropout=0.2):
        super().__init__()
        kernels = [kernels[min(i, 1)] for i in range(len(filters))]
        self.convs = nn.ModuleList(nn.Conv3d(a, b, k) for a, b, k in zip([in_channels, *filters], filters, kernels))
        self.bns = nn.ModuleList(nn.BatchNorm3d(n, eps=1e-5) for n in filters)
        size = [height, width, frames]
        for kernel in kernels:
            size = [(s - k + 1) // pool for s, k in zip(size, kernel)]
        self.fc3 = nn.Linear(filters[-1] * size[0] * size[1] * size[2], hidden)
        self.drop3 = nn.Dropout(dropout)
        self.fc4 = nn.Linear(hidden, classes)
        self.pool = pool

    def forward(self, x):
        for conv3d, bn in zip(self.convs, self.bns):
            x = torch.relu(bn(conv3d(x)))
            x = nn.functional.max_pool3d(x, self.pool) if self.pool > 1 else x
        return self.fc4(self.drop3(torch.relu(self.fc3(x.flatten(1)))))


class Scale(nn.Module):
    """One scale of paper 004: convolution of 3, batch norm, pool."""

    def __init__(self, inputs, outputs):
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, 3, padding=1)
        self.bn = nn.BatchNorm2d(outputs)

    def forward(self, x):
        return nn.functional.max_pool2d(self.bn(self.conv(x)), 2)


class MultiscaleBlock(nn.Module):
    def __init__(self, inputs, multi):
        super().__init__()
        self.k1 = nn.Parameter(torch.ones(1))
        self.k2 = nn.Parameter(torch.ones(1))
        self.single = Scale(inputs, 1)
        self.multi = Scale(inputs, multi)

    def forward(self, x):
        return torch.cat([self.k1 * self.single(x), self.k2 * self.multi(x), nn.functional.max_pool2d(x, 2)], 1)


class Multiscale(nn.Module):
    """Paper 004, Table 1."""

    def __init__(self, classes=20, in_channels=2, height=23, width=300, activation="leaky-relu"):
        super().__init__()
        self.activation = torch.sigmoid if activation == "sigmoid" else nn.functional.leaky_relu
        channels = in_channels
        for i, multi in enumerate([5, 15, 32]):
            setattr(self, f"block{i + 1}", MultiscaleBlock(channels, multi))
            channels += 1 + multi
        self.fc1 = nn.Linear(channels * (height // 8) * (width // 8), 512)
        self.bn1 = nn.BatchNorm1d(512)
        self.fc2 = nn.Linear(512, classes)
        self.bn2 = nn.BatchNorm1d(classes)

    def forward(self, x):
        for block in (self.block1, self.block2, self.block3):
            x = self.activation(block(x))
        return self.bn2(self.fc2(torch.sigmoid(self.bn1(self.fc1(x.flatten(1))))))


class DilatedBlock(nn.Module):
    def __init__(self, width, dilation):
        super().__init__()
        layer = lambda: nn.Conv1d(width, width, 3, padding=dilation, dilation=dilation, bias=False)  # noqa: E731
        self.conv1 = nn.Sequential(OrderedDict(conv=layer(), bn=nn.BatchNorm1d(width)))
        self.conv2 = nn.Sequential(OrderedDict(conv=layer(), bn=nn.BatchNorm1d(width)))

    def forward(self, x):
        return torch.relu(self.conv2(torch.relu(self.conv1(x))) + x)


class DilatedResNet(nn.Module):
    """taxel's own: 1x1 convolution, two residual blocks, mean, maximum and deviation over time."""

    def __init__(self, classes=3, in_channels=500, length=25, width=64):
        super().__init__()
        self.stem = nn.Sequential(OrderedDict(conv=nn.Conv1d(in_channels, width, 1, bias=False), bn=nn.BatchNorm1d(width)))
        self.drop1 = nn.Dropout(0.1)
        self.block1, self.block2 = DilatedBlock(width, 1), DilatedBlock(width, 2)
        self.norm = nn.BatchNorm1d(3 * width)
        self.drop2 = nn.Dropout(0.4)
        self.fc = nn.Linear(3 * width, classes)

    def forward(self, x):
        x = self.block2(self.block1(self.drop1(torch.relu(self.stem(x)))))
        deviation = (x.var(2, unbiased=False) + float(np.float32(1e-5))).sqrt()
        return self.fc(self.drop2(self.norm(torch.cat([x.mean(2), x.amax(2), deviation], 1))))


class RocketMember(nn.Module):
    """A perceptron on MiniRocket's features."""

    def __init__(self, features, hidden, classes):
        super().__init__()
        self.drop1, self.fc1 = nn.Dropout(0.3), nn.Linear(features, hidden)
        self.bn, self.drop2 = nn.BatchNorm1d(hidden), nn.Dropout(0.2)
        self.fc2 = nn.Linear(hidden, classes)

    def forward(self, x):
        return self.fc2(self.drop2(torch.relu(self.bn(self.fc1(self.drop1(x))))))


class DilatedResNetRocket(DilatedResNet):
    """taxel's own: logits of both members added; each has a loss of its own."""

    def __init__(self, classes=3, in_channels=500, length=25, width=64, features=1932, hidden=32):
        super().__init__(classes, in_channels, length, width)
        self.rocket = RocketMember(features, hidden, classes)

    def forward(self, x, features):
        self.members = super().forward(x), self.rocket(features)
        return self.members[0] + self.members[1]


ACTIVE_KERNELS, PALPATION_KERNELS = [(5, 5, 3), (5, 3, 3)], [(5, 3, 8), (5, 3, 8)]
# Filters, kernels, and the settings that differ from paper 002's second row.
TACTNETS_3D = {
    "tactnet3d": ([8, 16], ACTIVE_KERNELS, dict(classes=9)),
    "tactnet3d-4-8": ([4, 8], ACTIVE_KERNELS, dict(classes=9)),
    "tactnet3d-fc32": ([8, 16], ACTIVE_KERNELS, dict(classes=9, hidden=32)),
    "tactnet3d-8-16-32": ([8, 16, 32], ACTIVE_KERNELS, dict(classes=9)),
    "tactnet3d-51": ([16, 32], PALPATION_KERNELS, dict(classes=24, frames=51, dropout=0.7)),
}
TACTNETS = {"tactnet4": [8, 16, 32], "tactnet6": [8, 16, 32, 64, 128]}
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


def build(name, **settings):
    """The network `name` with `settings` in place of the paper's values."""
    if name in image_networks.NETWORKS:
        return image_networks.build(name, **settings)
    if name in TACTNETS_3D:
        filters, kernels, own = TACTNETS_3D[name]
        return TactNet3d(filters, kernels, **{**own, **settings})
    if name == "multiscale-cnn":
        return Multiscale(**settings)
    if name == "dilated-resnet-1d":
        return DilatedResNet(**settings)
    if name == "dilated-resnet-rocket-1d":
        return DilatedResNetRocket(**settings)
    return light(name, **settings)


def light(name, classes=3, in_channels=None, image_channels=3, in_features=250, hidden=128, height=50, width=50, **_sizes):
    """Networks of paper 000; where features are pooled globally, sizes beyond the channels do not matter."""
    if name == "mlp":
        return Mlp(in_features, hidden, classes)
    if name == "lstm":
        return Lstm(in_channels or 5, hidden, classes)
    if name in TACTNETS:
        return TactNet(in_channels or 3, TACTNETS[name], height, width, classes)
    if name == "tactresnet":
        return TactResNet(in_channels or 3, height, width, classes)
    if name in HYBRIDS:
        temporal, spatial, fuse = HYBRIDS[name]
        return Hybrid(temporal, spatial, fuse, in_channels or 5, image_channels, classes)
    body, dims = name.rsplit("-", 1)
    dims = int(dims[0])
    return add_classifier(BODIES[body](dims, in_channels or (5 if dims == 1 else 3)), classes)


def input_shapes(name, **settings):
    """Shapes of the inputs in order, batch axis left out."""
    if name in image_networks.NETWORKS:
        return image_networks.input_shapes(name, **settings)
    if name in TACTNETS_3D:
        sizes = {"in_channels": 1, "height": 28, "width": 50, "frames": 10, **TACTNETS_3D[name][2], **settings}
        return [tuple(sizes[key] for key in ("in_channels", "height", "width", "frames"))]
    if name == "multiscale-cnn":
        return [(settings.get("in_channels", 2), settings.get("height", 23), settings.get("width", 300))]
    if name.startswith("dilated-resnet"):
        signal = (settings.get("in_channels", 500), settings.get("length", 25))
        return [signal, (settings.get("features", 1932),)] if "rocket" in name else [signal]
    return light_input_shapes(name, **settings)


def light_input_shapes(name, classes=3, in_channels=None, image_channels=3, length=50, height=50, width=50, in_features=250, **_):
    if name == "mlp":
        return [(1, in_features)]
    if name in HYBRIDS:
        return [(in_channels or 5, length), (image_channels, height, width)]
    return [(in_channels or 5, length)] if name.endswith("1d") or name == "lstm" else [(in_channels or 3, height, width)]
